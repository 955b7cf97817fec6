"""`creak sweep --scheduler`: certificates that cannot be used are told, and so is a scheduler that is open to others."""

from __future__ import annotations

import pytest

from creak.studies.tasks.cluster import open_to_others
from helpers_decks import write_strips

TLS = "tls://127.0.0.1:1"


@pytest.fixture
def sweep(creak, tmp_path, monkeypatch):
    """Runs a small sweep with the words given; no scheduler ever answers."""
    pytest.importorskip("distributed")
    monkeypatch.setattr("creak.studies.tasks.cluster.WAIT", 0.5)
    write_strips(tmp_path)
    (tmp_path / "sweep.toml").write_text('base = "study.toml"\nseeds = [1]\n', encoding="utf-8")
    return lambda *words: creak("sweep", tmp_path / "sweep.toml", "--out", tmp_path / "out", *words)


@pytest.mark.parametrize(
    ("address", "others"),
    [
        ("tcp://127.0.0.1:8786", False),
        ("127.0.0.1:8786", False),
        ("tcp://localhost:8786", False),
        ("tcp://[::1]:1", False),
        ("tls://10.0.0.7:8786", False),
        ("tcp://10.0.0.7:8786", True),
        ("10.0.0.7:8786", True),
        ("tcp://node7:8786", True),
        ("ws://node7:8786", True),
        ("tcp://0.0.0.0:8786", True),
    ],
)
def test_a_scheduler_without_certificates_is_open_to_others(address, others):
    assert open_to_others(address) is others


def test_an_open_scheduler_is_warned_of(sweep):
    said = sweep("--scheduler", "tcp://192.0.2.1:9")
    assert "warning: the scheduler tcp://192.0.2.1:9 is open: whoever reaches it" in said.err
    assert said.status == 2
    assert "no dask scheduler at tcp://192.0.2.1:9" in said.err
    assert "is open" not in sweep("--scheduler", "tcp://127.0.0.1:1").err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--tls-cert", "a.crt"], "--tls-cert without --scheduler"),
        (["--scheduler", "tcp://127.0.0.1:1", "--tls-cert", "a.crt"], "expected an address tls://HOST:PORT"),
        (["--scheduler", TLS, "--tls-ca-file", "none.crt"], "--tls-ca-file: no such file: none.crt"),
        (["--scheduler", TLS], "asks for certificates, none are named"),
    ],
)
def test_certificates_that_do_not_fit(sweep, words, told):
    said = sweep(*words)
    assert said.status == 2
    assert told in said.err
    assert "Traceback" not in said.err


def test_a_certificate_that_is_none(sweep, tmp_path):
    wrong = tmp_path / "wrong.crt"
    wrong.write_text("no certificate", encoding="utf-8")
    said = sweep("--scheduler", TLS, "--tls-ca-file", wrong, "--tls-cert", wrong, "--tls-key", wrong)
    assert said.status == 2
    assert "the certificates cannot be used" in said.err
