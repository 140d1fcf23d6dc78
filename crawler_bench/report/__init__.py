"""What is shown to people: generated blocks of the pages, and the data of the playground."""
