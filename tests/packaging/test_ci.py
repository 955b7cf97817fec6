"""`.ci/run` installs a browser for the tests of pages where there is none, and says why where it cannot."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

RUN = Path(__file__).parents[2] / ".ci" / "run"
SUDO = '#!/bin/sh\nshift\nexec "$@"\n'


def installed(folder, **programs):
    """What `install_chromium` says, and how it called apt-get, where only these programs are there."""
    for name, text in {"sudo": SUDO, **programs}.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    for name in ("bash", "sh", "env", "true"):
        (folder / name).symlink_to(shutil.which(name))
    text = RUN.read_text(encoding="utf-8")
    function = text[text.index("install_chromium() {") :].partition("\n}\n")[0] + "\n}\n"
    line = [str(folder / "bash"), "-euo", "pipefail", "-c", f"{function}install_chromium"]
    done = subprocess.run(line, env={"PATH": str(folder)}, capture_output=True, text=True, check=True, cwd=folder)
    calls = folder / "calls"
    return done.stdout.strip(), calls.read_text().splitlines() if calls.exists() else []


@pytest.mark.skipif(os.name != "posix", reason="a script of bash")
def test_chromium_is_installed_where_there_is_no_browser(tmp_path):
    kinds = {
        "new": ({"apt-get": "#!/bin/sh\necho $DEBIAN_FRONTEND $* >>calls\n"}, ""),
        "has one": ({"apt-get": "#!/bin/sh\necho $* >>calls\n", "google-chrome": "#!/bin/sh\n"}, ""),
        "no Debian": ({}, "there is no apt-get"),
        "no network": ({"apt-get": "#!/bin/sh\nexit 100\n"}, "apt-get could not install it"),
        "no rights": ({"apt-get": "#!/bin/sh\n", "sudo": "#!/bin/sh\nexit 1\n"}, "this takes root or sudo"),
    }
    if os.geteuid() == 0:
        del kinds["no rights"]
    for kind, (programs, why) in kinds.items():
        (tmp_path / kind).mkdir()
        said, calls = installed(tmp_path / kind, **programs)
        assert said.startswith(why), kind
        assert bool(said) == bool(why), kind
        if kind == "new":
            assert calls == ["update -qq", "noninteractive install -y -qq --no-install-recommends chromium"]
        else:
            assert calls == []
