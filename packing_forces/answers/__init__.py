"""What a verb hands back, and how numbers are said."""
