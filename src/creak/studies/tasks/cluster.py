"""Jobs on a dask cluster that is there already."""

from __future__ import annotations

import ipaddress
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from creak.errors import InputError
from creak.studies.tasks.queue import DIED, Ended, Job, Queue, Runner, run_job

if TYPE_CHECKING:
    from distributed import Client, Future
    from distributed.security import Security

WAIT = 30.0
"""s to wait for a scheduler."""
RETRIES = 2
"""Of a job whose worker was lost in a way that the scheduler does not see by itself."""


@dataclass(frozen=True)
class Certificates:
    """Files that prove to a scheduler who asks, and to us who answers; what is None, dask's own settings may name."""

    ca: Path | None = None
    """Of the authority that signed all certificates of the cluster."""
    cert: Path | None = None
    key: Path | None = None
    """Private key of the certificate; None: it lies in the same file."""

    @property
    def files(self) -> dict[str, Path]:
        """Option -> file, of those that were given."""
        named = {"--tls-ca-file": self.ca, "--tls-cert": self.cert, "--tls-key": self.key}
        return {option: path for option, path in named.items() if path is not None}


def need_distributed() -> None:
    """Raises InputError, with what to install, where dask.distributed is not there."""
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise InputError(
            "--scheduler needs dask.distributed, which is not installed",
            fix="pip install 'creak[cluster]' or: pip install distributed",
        ) from error


def open_to_others(address: str) -> bool:
    """Whether a scheduler at this address takes work from anyone whose packets reach it: no TLS, not this machine."""
    parts = urlsplit(address if "://" in address else f"tcp://{address}")
    if parts.scheme in ("tls", "wss", "inproc"):
        return False
    host = parts.hostname or ""
    try:
        return not ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host != "localhost"


@contextmanager
def running_cluster(address: str, certificates: Certificates = Certificates()) -> Iterator[Runner]:
    """A cluster by the address of its scheduler; its workers keep the threads they were started with.

    Raises
    ------
    InputError : certificates that are not there or cannot be used, nothing answers at the address, or workers take
        several cases at once.
    """
    from distributed import Client

    security = _security(address, certificates)
    try:
        client = Client(address, timeout=WAIT, security=security)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise InputError(
            f"no dask scheduler at {address}: {error}",
            expected="an address such as tls://host:8786",
            fix="Start it with: dask scheduler, and name the same certificates there and here.",
        ) from error
    with client:
        workers = client.scheduler_info(n_workers=-1)["workers"]
        several = next((w for w in workers.values() if w["nthreads"] > 1), None)
        if several is not None:
            raise InputError(
                f"worker {several['name']} would run {several['nthreads']} cases at once",
                expected="one at a time",
                fix="Start the workers with: dask worker ADDRESS --nthreads 1",
            )
        yield partial(outcomes, client)


def _security(address: str, certificates: Certificates) -> Security | None:
    """What dask is told of certificates; None: its own settings, which may name some."""
    from distributed.security import Security

    files = certificates.files
    if files and not address.startswith("tls://"):
        raise InputError(
            f"{next(iter(files))} with the scheduler {address}",
            expected="an address tls://HOST:PORT",
            fix="Certificates are of use with TLS only.",
        )
    for option, path in files.items():
        if not path.is_file():
            raise InputError(f"no such file: {path}", where=option, fix="Check the path.")
    if not address.startswith("tls://"):
        return None
    given: dict[str, Any] = {}
    if certificates.ca is not None:
        given["tls_ca_file"] = str(certificates.ca)
    if certificates.cert is not None:
        given["tls_client_cert"] = str(certificates.cert)
        given["tls_client_key"] = None if certificates.key is None else str(certificates.key)
    try:
        security = Security(require_encryption=True, **given)
        context = security.get_connection_args("client")["ssl_context"]
    except (OSError, ValueError) as error:
        raise InputError(
            f"the certificates cannot be used: {error}",
            where="--tls-ca-file, --tls-cert, --tls-key",
            expected="files in PEM, the key that of the certificate",
        ) from error
    if context is None:
        raise InputError(
            f"the scheduler {address} asks for certificates, none are named",
            expected="those of the cluster",
            fix="Name them with --tls-ca-file, --tls-cert and --tls-key, or in dask's own settings.",
        )
    return security


def outcomes(client: Client, tasks: Sequence[Job[Ended]]) -> Iterator[tuple[str, Ended]]:
    """Yield (name, what it told) of every task as it ends.

    No more tasks are handed out than there are workers: one that kills its worker takes no other along. A task
    whose worker dies more often than the scheduler allows has failed.
    """
    from distributed import as_completed

    queue, start, most = Queue(list(tasks)), time.perf_counter(), 1
    running: dict[str, Job[Ended]] = {}
    submitted = as_completed(raise_errors=False)

    def submit() -> None:
        nonlocal most
        most = max(most, len(client.scheduler_info(n_workers=-1)["workers"]))
        for task in queue.ready(most - len(running)):
            future = client.submit(run_job, task, key=f"{task.name}-{task.id}", pure=False, retries=RETRIES)
            running[future.key] = task
            submitted.add(future)

    submit()
    for future in submitted:
        task = running.pop(future.key)
        queue.ended(task)
        outcome = _outcome(future, task, start)
        future.release()
        submit()
        yield task.name, outcome


def _outcome(future: Future, task: Job[Ended], start: float) -> Ended:
    if future.status == "finished":
        outcome: Ended = future.result()
        return outcome
    error = future.exception() if future.status == "error" else None
    died = type(error).__name__ == "KilledWorker"
    return task.lost(DIED if died else str(error or f"{future.status} by dask"), start)
