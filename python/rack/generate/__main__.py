"""python3 -m rack.generate: see its --help."""

from __future__ import annotations

import argparse
import json
import pathlib
import sys

from .c import CWriter
from .description import Description
from .java import JavaWriter
from .python import PythonWriter


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python3 -m rack.generate", description="Writes a module of Python, a header of C, or classes of Java, for messages.",
        epilog="Example: python3 -m rack.generate share/rack/messages/thermometer.json > thermometer.py")
    parser.add_argument("description", type=pathlib.Path, metavar="DESCRIPTION.json",
                        help="what tims-schema prints, or the message file of a class (share/rack/messages)")
    languages = parser.add_mutually_exclusive_group()
    languages.add_argument("--c", action="store_true", help="a header for C, which uses rack_codec.h")
    languages.add_argument("--java", type=pathlib.Path, metavar="FOLDER",
                           help="classes for Java, which use rack.jar; FOLDER is of sources")
    given = parser.parse_args()
    try:
        description = Description(json.loads(given.description.read_text("utf-8")))
        if given.java:
            return _write(given.java, JavaWriter(description).files())
        text = CWriter(description).text() if given.c else PythonWriter(description).text()
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"{given.description}: no description of messages: {error!r}", file=sys.stderr)
        return 1
    sys.stdout.write(text)
    return 0


def _write(folder: pathlib.Path, files: dict[str, str]) -> int:
    for name, text in files.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, "utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
