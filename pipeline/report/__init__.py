"""Tables, plots, the HTML page and the exported files."""
