"""`adaptnet bench`: one file for each thing whose speed it measures."""

__all__: list[str] = []
