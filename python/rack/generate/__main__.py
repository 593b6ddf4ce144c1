"""python3 -m rack.generate: see its --help."""

import argparse
import json
import pathlib
import sys

from .c import CWriter
from .description import Description
from .python import PythonWriter


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python3 -m rack.generate", description="Writes a module of Python, or a header of C, for messages.",
        epilog="Example: python3 -m rack.generate share/rack/messages/thermometer.json > thermometer.py")
    parser.add_argument("description", type=pathlib.Path, metavar="DESCRIPTION.json",
                        help="what tims-schema prints, or the message file of a class (share/rack/messages)")
    parser.add_argument("--c", action="store_true", help="a header for C, which uses rack_codec.h")
    given = parser.parse_args()
    try:
        description = Description(json.loads(given.description.read_text("utf-8")))
        text = CWriter(description).text() if given.c else PythonWriter(description).text()
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"{given.description}: no description of messages: {error!r}", file=sys.stderr)
        return 1
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
