"""Undamped modes of K x = omega^2 M x: shift-invert block Lanczos with a Sturm check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as sla
import scipy.sparse as sp

from creak.arrays import FloatArray, Matrix, to_dense
from creak.later import later
from creak.linalg.dense_product import inner, product, symmetric
from creak.linalg.factor import Factor, LaterFactor, SingularMatrixError
from creak.linalg.lanczos import FEWER, Ritz, basis_bytes, lanczos
from creak.linalg.memory import MADE, fits, free_bytes, require
from creak.linalg.pencil import Pencil, dense_pairs
from creak.linalg.pieces.factor import Pieces
from creak.linalg.sparse_product import BlockProduct, copy_fits
from creak.linalg.threads import one_blas_thread
from creak.linalg.windows import AMID, amid_or_in_windows, are_apart
from creak.progress import Steps

DENSE_LIMIT = 600
"""Up to this size the dense eigensolver is faster and simpler."""
SHARE = 0.3
"""From this share of all modes on the dense eigensolver is faster at any size, where memory holds its matrices."""
DENSE_MATRICES = 5
"""Of the size of K, that it takes."""
RIGID = 0.02
"""Eigenvalues of a free body below this share of the shift are its rigid-body modes."""
MANY = 32
"""From so many modes on a factor amid them pays."""
FEW = 0.05
"""Share of the free memory that a block of columns takes when residuals are looked at; there are six."""
LOW = 0.02
"""Modes below this share of the shift amid them are refined."""
COLUMNS = 64
"""Modes whose residuals are measured at a time."""
BAND, HALF_AGAIN, AT_LEAST = 1.5, 0.5, 3
"""Further modes: all up to this multiple of f_max, at least this share of those below it, and so many."""
AFTER = 1.05
"""Shift over the first eigenvalue that is sought, at least."""
ENDS = 12
"""Modes on either side of where new ones begin that are looked at: none may be found twice."""


@dataclass(frozen=True)
class Modes:
    """Eigenpairs, mass-normalised and sorted."""

    omega2: FloatArray
    """(n_mode,) eigenvalues, rad^2/s^2; rigid-body modes are exactly 0."""
    shapes: FloatArray
    """(n, n_mode), shapes' M shapes = I."""
    residual: float
    """Largest |K x - omega^2 M x| / |K x| over the elastic modes."""
    sturm_ok: bool
    """The inertia count at the upper end agrees with the number of modes found."""
    next_omega2: float = np.nan
    """The eigenvalue just above those returned, rad^2/s^2, to the same accuracy: inf where there is none, nan where
    it was not sought (Lanczos with `count`)."""
    columns: int = 0
    """Vectors that went through the factor of K - shift M."""

    @property
    def frequencies(self) -> FloatArray:
        """(n_mode,) Hz."""
        return np.sqrt(np.maximum(self.omega2, 0.0)) / (2.0 * np.pi)


def lowest(found: Modes, count: int) -> Modes:
    """The first `count` of more modes; their shapes are looked up when they are asked for."""
    known = {name: getattr(found, name) for name in ("residual", "sturm_ok", "columns")}
    known |= {"omega2": found.omega2[:count], "next_omega2": float(found.omega2[count])}
    return later(Modes, lambda: Modes(shapes=found.shapes[:, :count], **known), **known)


def with_further(kept: int, in_band: int) -> int:
    """How many modes there are to be with the further ones: `kept` lie below f_max, `in_band` below `BAND` f_max."""
    return max(in_band, kept + max(AT_LEAST, -int(-HALF_AGAIN * kept // 1)))


@one_blas_thread()
def modes(
    K: Matrix,
    M: Matrix,
    *,
    f_max: float | None = None,
    count: int | None = None,
    further: bool = False,
    found: Modes | None = None,
    free: bool = False,
    stiffness_factor: Factor | None = None,
    sturm: bool = True,
    pieces: Pieces | None = None,
    progress: Steps | None = None,
) -> Modes:
    """All modes up to `f_max` (Hz), or the `count` lowest.

    Parameters
    ----------
    K, M : (n, n) symmetric sparse or dense; M may be singular, K + s M must not be. Without
        mass there are no modes.
    further : with `f_max`, the next ones beyond it too, wherever they lie, as many as `with_further` says: they show
        what leaving them out changes. Fewer only where the body has no more.
    found : with `further`, the lowest modes, all below `f_max` at least, that are known already. They count as
        those below it, and are returned with the others, which alone are computed.
    free : the body may have rigid-body modes: a small negative shift is used. A clamped K is factorised as is.
    stiffness_factor : a factor of K that already exists (clamped only).
    sturm : with `count`, compare with the inertia above the last mode, one more factorisation; `f_max` always does.
    pieces : how K and M are cut where memory does not hold a factor of them.

    Raises
    ------
    NumericalError : K is singular though the body was called clamped, or Lanczos missed a mode.

    Method: shift-invert block Lanczos (`linalg.lanczos`) without restart; the number of modes below `f_max` comes
    from the inertia of K - omega^2 M. `progress(done, total)` rises to the number of modes.
    """
    n = K.shape[0]
    if (f_max is None) == (count is None):
        raise ValueError("give either f_max or count")
    if not M.diagonal().any():
        return Modes(np.zeros(0), np.zeros((n, 0)), 0.0, True, np.inf)
    if n <= DENSE_LIMIT:
        return _dense_modes(K, M, f_max, count, free, further=further, known=_count(found))
    shift = -small_shift(K, M) if free else 0.0
    pencil = Pencil(K, M, pieces)
    _ = pencil.mass  # what is free is looked at beside it
    inverse = stiffness_factor or LaterFactor(lambda: pencil.factor(shift, definite=True))
    try:
        _make_now(inverse)
    except SingularMatrixError as error:
        raise SingularMatrixError(
            error.row, f"the stiffness matrix is singular at row {error.row}: is the body held?"
        ) from error
    if f_max is None:
        return _lowest(pencil, shift, min(int(count or 0), n), inverse, free, sturm, progress)
    if found is not None and (more := _beyond(pencil, (2.0 * np.pi * f_max) ** 2, found, inverse, free, progress)):
        return more
    upper = (2.0 * np.pi * f_max) ** 2
    return _below(pencil, shift, upper, inverse, free, progress, _count(found) if further else None)


def _lowest(
    pencil: Pencil, shift: float, count: int, inverse: Factor, free: bool, sturm: bool, progress: Steps | None
) -> Modes:
    """The `count` lowest modes; the inertia above the last one tells whether one was missed."""
    if count == 0:
        return Modes(np.zeros(0), np.zeros((pencil.mass.n, 0)), 0.0, True)
    if dense_is_faster(pencil.mass.n, count):
        return _by_dense(pencil, shift, count, inverse, free)
    found = lanczos(inverse, pencil.mass, shift, count, progress=progress)
    return _checked(pencil, found.lam, found.shapes, free, count=sturm, columns=found.columns)


def _below(
    pencil: Pencil,
    shift: float,
    upper: float,
    inverse: Factor,
    free: bool,
    progress: Steps | None,
    known: int | None,
) -> Modes:
    """All modes below omega^2 = `upper` and the eigenvalue after them; their number is the inertia of K - upper M.

    With a number of `known` ones the further ones too. Where memory is short, one factor is held at a time, and the
    modes are found window by window.
    """
    made = 0.0 if pencil.pieces is not None else MADE * getattr(pencil.K, "nnz", 0)
    _make_room(inverse, inverse.memory + made)
    band = upper if known is None else BAND**2 * upper
    counted, placed = pencil.counted(band), band
    in_band = wanted = counted.n_negative
    many = in_band >= MANY
    if known is not None and many:
        counted, placed = pencil.counted(upper, counted), upper
    if known is not None:
        wanted = with_further(max(counted.n_negative, known), in_band)  # of few some too many, without another factor
    if dense_is_faster(pencil.mass.n, wanted):
        del counted
        return _by_dense(pencil, shift, wanted, inverse, free)
    if many:
        _make_room(inverse, basis_bytes(pencil.mass.n, wanted + 1))
        found, amid = amid_or_in_windows(pencil, band, counted, placed, wanted, in_band, progress)
        del counted
    else:
        del counted
        above = band * (1.0 + 1e-6)
        found = lanczos(inverse, pencil.mass, shift, wanted, extra=1, upper=above, within=in_band, progress=progress)
        amid = shift
    low = _refined(inverse, shift, pencil.mass, found, amid)
    if known is not None:
        wanted = with_further(max(int(np.count_nonzero(found.lam <= upper)), known), in_band)
    after = found.lam[wanted] if found.lam.size > wanted else np.inf
    lam, shapes = found.lam[:wanted], found.shapes[:, :wanted]
    return _checked(pencil, lam, shapes, free, after=after, columns=found.columns + low)


def dense_is_faster(n: int, wanted: int) -> bool:
    """Whether `wanted` modes of n equations are so many that the dense eigensolver takes less time, and it fits.

    Both costs grow with n^3 at a given share; that of Lanczos is mostly the eigenproblem of T, whose size is 1.7 to
    2.7 times `wanted`.
    """
    return wanted > SHARE * n and fits(dense_bytes(n))


def dense_bytes(n: int) -> float:
    """Memory of the dense eigensolver."""
    return DENSE_MATRICES * 8.0 * float(n) ** 2


def _count(found: Modes | None) -> int:
    return 0 if found is None else found.omega2.size


def _beyond(
    pencil: Pencil, upper: float, found: Modes, inverse: Factor, free: bool, progress: Steps | None
) -> Modes | None:
    """`found` with the further modes of omega^2 = `upper`; None where all are to be computed anew.

    The factor that counts those below `BAND` times the frequency is at the shift, or just after the first one sought;
    those nearest to it converge first. Of many the shift is amid them.
    """
    if found.next_omega2 == np.inf:
        return found
    n, known, band = pencil.mass.n, _count(found), BAND**2 * upper
    _make_room(inverse, inverse.memory)
    shift = max(band, AFTER * found.next_omega2)
    counted = pencil.counted(shift)
    below = counted.n_negative - known
    more = with_further(known, counted.n_negative if shift == band else known) - known
    if below < 0 or dense_is_faster(n, known + more):
        return None
    require(16.0 * n * (known + more), f"{known + more:,} modes of {n:,} equations", FEWER)
    lower = float(found.omega2[-1]) if known else -np.inf
    above = shift * (1.0 + 1e-6)
    if known and MANY <= below <= more:  # amid the ones that are sought: half as many others converge with them
        shift = lower + AMID * (shift - lower)
        counted = pencil.counted(shift, counted)
    below = min(below, more)
    new = lanczos(
        counted,
        pencil.mass,
        shift,
        more,
        extra=1,
        skip=known,
        lower=lower,
        upper=above,
        within=below,
        progress=progress,
    )
    if not are_apart(pencil.mass, found.shapes[:, -ENDS:], new.shapes[:, :ENDS]):
        return None
    after = new.lam[more] if new.lam.size > more else np.inf
    lam, shapes = np.concatenate([found.omega2, new.lam[:more]]), np.hstack([found.shapes, new.shapes[:, :more]])
    return _checked(pencil, lam, shapes, free, after=after, columns=found.columns + new.columns)


def _by_dense(pencil: Pencil, shift: float, wanted: int, inverse: Factor, free: bool) -> Modes:
    """The lowest modes by the dense eigensolver; the lowest of them, which its round-off blurs, are refined."""
    lam, X, _ = dense_pairs(to_dense(pencil.K), to_dense(pencil.M))
    after = lam[wanted] if lam.size > wanted else np.inf
    found = Ritz(lam[:wanted].copy(), np.asfortranarray(X[:, :wanted]), 0)
    del X
    low = _refined(inverse, shift, pencil.mass, found, found.lam[-1])
    return _checked(pencil, found.lam, found.shapes, free, after=after, columns=low)


def _make_now(inverse: Factor) -> None:
    if isinstance(inverse, LaterFactor):
        _ = inverse.made


def _make_room(inverse: Factor, needed: float) -> None:
    """Give a factor that can be made again back where there is no memory for `needed` bytes beside it."""
    if isinstance(inverse, LaterFactor) and not fits(needed):
        inverse.release()


def _refined(inverse: Factor, shift: float, mass: BlockProduct, found: Ritz, amid: float) -> int:
    """One inverse iteration with Rayleigh-Ritz, in place, on the modes far below `amid`; returns how many these are.

    1 / (lam - amid) hardly differs among them; 1 / (lam - shift) does. `inverse`: a factor of K - shift M.
    """
    low = 0 if amid == shift else int(np.searchsorted(found.lam, LOW * amid))
    if low:
        # One inverse iteration: the Ritz vectors of (K - shift M)^-1 M X, M-orthonormal, and their eigenvalues.
        MX = mass(found.shapes[:, :low])
        Y = inverse.solve(MX)
        stiffness = inner(Y, MX)  # Y' (K - shift M) Y = Y' M X
        values, S = sla.eigh(symmetric(stiffness), symmetric(inner(Y, mass(Y))))
        found.shapes[:, :low], found.lam[:low] = product(Y, S), shift + values
    return low


def small_shift(K: Matrix, M: Matrix) -> float:
    """A shift far below the first elastic eigenvalue of any mesh, far above round-off in K; 1 where no mass has any."""
    k, m = K.diagonal(), M.diagonal()
    both = (k > 0.0) & (m > 0.0)
    return float(1e-9 * np.median(k[both] / m[both])) if both.any() else 1.0


def _dense_modes(
    K: Matrix, M: Matrix, f_max: float | None, count: int | None, free: bool, *, further: bool = False, known: int = 0
) -> Modes:
    dense_K, dense_M = to_dense(K), to_dense(M)
    if dense_K.shape[0] == 0:
        return Modes(np.zeros(0), np.zeros((0, 0)), 0.0, True, np.inf)
    omega2, shapes, round_off = dense_pairs(dense_K, dense_M)
    if f_max is not None:
        below = [int(np.count_nonzero(omega2 <= (2.0 * np.pi * f) ** 2)) for f in (f_max, BAND * f_max)]
        count = with_further(max(below[0], known), below[1]) if further else below[0]
    keep = np.arange(omega2.size) < (count or 0)
    after = float(omega2[~keep].min(initial=np.inf))
    pencil = Pencil(dense_K, dense_M)
    return _checked(pencil, omega2[keep], shapes[:, keep], free, round_off=round_off, after=after)


def _checked(
    pencil: Pencil,
    omega2: FloatArray,
    shapes: FloatArray,
    free: bool,
    *,
    count: bool = False,
    round_off: float = 0.0,
    after: float = np.nan,
    columns: int = 0,
) -> Modes:
    """Clean rigid-body values to 0, measure residuals; `count`: compare with the inertia just above the last."""
    K = pencil.K
    scale = max(abs(small_shift(K, pencil.M)), 1e-300)
    rigid = max(RIGID * scale, round_off)
    omega2 = np.where(np.abs(omega2) < rigid, 0.0, omega2) if free else omega2
    after = 0.0 if free and abs(after) < rigid else after
    sturm_ok = True
    if count and sp.issparse(K) and omega2.size and omega2.size < K.shape[0]:
        above = pencil.factor(omega2[-1] * (1.0 + 1e-6) + 1e-3 * scale, definite=False)
        sturm_ok = above.n_negative == omega2.size or _last_is_repeated(omega2)
    return Modes(omega2, shapes, _residual(pencil, omega2, shapes), sturm_ok, float(after), columns)


def _residual(pencil: Pencil, omega2: FloatArray, shapes: FloatArray) -> float:
    """Largest |K x - omega^2 M x| / |K x| over the elastic modes, some columns at a time."""
    stiffness, worst = BlockProduct(pencil.K, own=copy_fits(pencil.K)), 0.0
    columns = int(min(max(FEW * free_bytes() / (8.0 * stiffness.n), 1), COLUMNS))
    Kx = Mx = None
    for first in range(int(np.count_nonzero(omega2 <= 0.0)), omega2.size, columns):
        some = slice(first, first + columns)
        Kx, Mx = stiffness(shapes[:, some], Kx), pencil.mass(shapes[:, some], Mx)
        size = _lengths(Kx)
        Mx *= omega2[some]
        Kx -= Mx
        worst = max(worst, float((_lengths(Kx) / size).max()))
    return worst


def _lengths(X: FloatArray) -> FloatArray:
    """Of columns; `np.linalg.norm` makes copies of them."""
    return np.sqrt(np.einsum("ij,ij->j", X, X))


def _last_is_repeated(omega2: FloatArray) -> bool:
    """The count may cut through a repeated eigenvalue; then the inertia counts its twin too."""
    return bool(omega2.size > 1 and omega2[-1] > 0.0 and omega2[-2] > omega2[-1] * (1.0 - 1e-5))
