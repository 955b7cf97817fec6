"""Options of the commands that can use a dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from creak.cli.output import Output
from creak.errors import InputError

if TYPE_CHECKING:
    from creak.studies.file.places import Places
    from creak.studies.tasks.cluster import Certificates
    from creak.studies.tasks.queue import Runner

WORKERS = typer.Option(
    None,
    "--workers",
    min=1,
    help="Reduce the parts in so many processes, which share the cores; default: in this one.",
)
"""Of the commands that reduce one study."""
SCHEDULER = typer.Option(
    None, "--scheduler", metavar="ADDRESS", help="Run on the cluster of this dask scheduler instead."
)
TLS_CA_FILE = typer.Option(
    None,
    "--tls-ca-file",
    metavar="FILE",
    help="Certificate of the authority of a tls:// scheduler, PEM; default: dask's own settings.",
)
TLS_CERT = typer.Option(None, "--tls-cert", metavar="FILE", help="Certificate to show to a tls:// scheduler, PEM.")
TLS_KEY = typer.Option(
    None,
    "--tls-key",
    metavar="FILE",
    help="Private key of that certificate, PEM; default: it lies in the same file.",
)


@dataclass(frozen=True)
class Distribution:
    """Where jobs are done."""

    workers: int | None
    """Processes, or threads, of this machine; None: the user does not say."""
    scheduler: str | None
    certificates: Certificates


def distribution_of(
    workers: int | None = WORKERS,
    scheduler: str | None = SCHEDULER,
    tls_ca_file: Path | None = TLS_CA_FILE,
    tls_cert: Path | None = TLS_CERT,
    tls_key: Path | None = TLS_KEY,
    *,
    own: str = "--workers",
) -> Distribution:
    """What the options say.

    Parameters
    ----------
    own : the name of the first option, which is for this machine alone.

    Raises
    ------
    InputError : options that exclude each other.
    """
    from creak.studies.tasks.cluster import Certificates

    if workers is not None and scheduler is not None:
        raise InputError(f"{own} and --scheduler exclude each other", fix="A cluster has its own workers.")
    certificates = Certificates(tls_ca_file, tls_cert, tls_key)
    if scheduler is None and certificates.files:
        raise InputError(
            f"{next(iter(certificates.files))} without --scheduler",
            expected="--scheduler tls://HOST:PORT",
            fix="Workers on this machine need no certificates.",
        )
    return Distribution(workers, scheduler, certificates)


@contextmanager
def workers_of(where: Distribution, count: int) -> Iterator[Runner]:
    """The cluster of a scheduler, or else so many workers of this machine."""
    from creak.studies.tasks.cluster import running_cluster
    from creak.studies.tasks.queue import local_workers

    address = where.scheduler
    with local_workers(count) if address is None else running_cluster(address, where.certificates) as runner:
        yield runner


def check_cluster(where: Distribution, output: Output) -> None:
    """Raise InputError where dask is missing for a scheduler; warn of one that is open to others."""
    from creak.studies.tasks.cluster import need_distributed, open_to_others

    if where.scheduler is None:
        return
    need_distributed()
    if open_to_others(where.scheduler):
        output.warn(
            f"the scheduler {where.scheduler} is open: whoever reaches it, or its workers, can run code as their "
            "owner; use certificates and tls://, see docs/sweeps.md"
        )


def check_method(method: str, places: Places) -> None:
    """Raise InputError where a study's method of reduction makes no superelements."""
    if method not in ("craig-bampton", "guyan"):
        raise InputError(
            f"method = {method!r} makes no superelements",
            where=places.where("reduction", "method"),
            expected='"craig-bampton" or "guyan"',
            fix="`creak run` by itself takes any method.",
        )
