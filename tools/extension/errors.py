"""What a person is told when the extension cannot be made."""


class ExtensionError(Exception):
    """One sentence that names what is missing and what to do."""
