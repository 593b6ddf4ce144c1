"""The console's own checks: Biome (style, accessibility) and TypeScript."""

import shutil
import subprocess

from tree import Finding

LINES_MAX = 60


def check(tree):
    """Without its packages (console/node_modules), which the build installs, nothing can be checked."""
    if not tree.has("console/node_modules/.package-lock.json") or not shutil.which("npm"):
        return
    run = subprocess.run(["npm", "run", "--silent", "check"], cwd=tree.root / "console",
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if run.returncode != 0:
        text = "\n".join(run.stdout.strip().splitlines()[-LINES_MAX:])
        yield Finding("console", 0, f"npm run check found: {text}")
