"""The Comment's figures, one script each; no science inside, only calls and plotting.

python -m paper_figs            quick: a minute, to build/figures
python -m paper_figs --full     publication version, to figures
"""
