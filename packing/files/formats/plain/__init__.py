"""Tables with a line of column names: commas, semicolons, tabs or blanks between them."""
