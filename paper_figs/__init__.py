"""The Comment's figures and those of the docs, one module each: they draw, from tables.

python -m paper_figs                 quick: two minutes, to build/figures
python -m paper_figs --full          publication version, to figures
python -m paper_figs --from-tables   drawn again in seconds from the tables that are there
"""
