"""Messages for programs in other languages, from the description that tims-schema prints, or from a message file.

It imports nothing of the package rack, whose module `messages` it writes.
"""
