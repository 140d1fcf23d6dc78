"""Folders that many processes share: what names them, who works on them, whether they are as written."""
