"""The components of RACK: their messages, calls for them, and components in Python.

    rack.messages     bodies of all messages, types, and a proxy for each class
    rack.proxy        what proxies are made of
    rack.codec        structs to and from bytes
    rack.generate     Python, C and Java for the messages of your own classes
    rack.module       Module and DataModule, the bases of components
"""

from ._rack import time_stamp
from .codec import CodecError, Struct
from .module import AT_ON, AT_START, NOW, Command, DataModule, Module, Parameter, Refused, integer, partner, real, text
from .proxy import DataProxy, Proxy, Timeouts

__all__ = [
    "AT_ON", "AT_START", "NOW", "CodecError", "Command", "DataModule", "DataProxy", "Module", "Parameter", "Proxy", "Refused", "Struct", "Timeouts",
    "integer", "partner", "real", "text", "time_stamp",
]
