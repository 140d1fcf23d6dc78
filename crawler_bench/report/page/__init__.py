"""`crawler-bench report`: what is in results/ as one HTML file."""
