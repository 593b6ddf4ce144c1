"""The README's Python, block after block, in one session; what its comments promise is printed."""

import contextlib
import io
import os
import pathlib
import re
import unittest

from support import WithRouter

README = pathlib.Path(os.environ["TIMS_SOURCES"]) / "python" / "README.md"


class Readme(WithRouter):
    def test_its_code_runs(self):
        text = README.read_text(encoding="utf-8")
        names = {}
        printed = io.StringIO()
        blocks = list(re.finditer(r"```python\n(.*?)```", text, re.DOTALL))
        self.assertGreaterEqual(len(blocks), 3)
        with contextlib.redirect_stdout(printed):
            for block in blocks:
                if not re.match(r"#!|# file", block[1]):
                    line = text.count("\n", 0, block.start()) + 1
                    exec(compile("\n" * line + block[1], str(README), "exec"), names)
        for promise in ("21 b'hello'", "NOT_AVAILABLE", "22 b'soon'", "Chassis(0/0), ON", "8.0 True"):
            self.assertIn(promise, printed.getvalue())


if __name__ == "__main__":
    unittest.main()
