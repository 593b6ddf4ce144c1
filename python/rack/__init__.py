"""The components of RACK: their messages, calls for them, and components in Python.

    rack.messages     bodies of all messages, types, and a proxy for each class
    rack.proxy        what proxies are made of
    rack.codec        structs to and from bytes
    rack.generate     Python for the messages of your own classes
"""
