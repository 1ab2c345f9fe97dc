"""The figures of docs/estimators.md and docs/trade.md, one module each, as those of the paper."""
