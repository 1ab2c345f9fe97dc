"""One module a verb, loaded when it is asked for: ``answer(arguments) -> Answer``."""
