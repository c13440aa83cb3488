from os import PathLike
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self

Callback = Optional[Callable[[int, int], Any]]
Products = Tuple[str, str, Union[str, float], bool, Optional[int], Optional[str]]
Csr = Tuple[Any, Any, Any, Tuple[int, int]]
Path = Union[str, PathLike[str]]
Array = NDArray[Any]
Pieces = Tuple[int, int, int, int, int]
MeshArrays = Tuple[Array, Array]
PartArrays = Tuple[MeshArrays, Array, Array]
RefinedArrays = Tuple[MeshArrays, Array, Array, Array]
FoundCurves = Tuple[str, bool, List[Dict[str, Any]], Array, Array]
BasisParts = Tuple[Array, Array, Array, Pieces]

__version__: str

class Nearest:
    def __enter__(self) -> None: ...
    def __exit__(self, *exception: Any) -> None: ...

def get_num_threads() -> int: ...
def set_num_threads(threads: int) -> None: ...

class Plan:
    @property
    def is_exact(self) -> bool: ...
    @property
    def is_fast(self) -> bool: ...
    @property
    def scheme(self) -> str: ...
    @property
    def isa(self) -> Optional[str]: ...

class Accumulator:
    def __new__(
        cls,
        columns: int,
        center: bool,
        scalar: str,
        kind: str,
        bounds: Optional[Tuple[ArrayLike, ArrayLike, int, Optional[float]]],
    ) -> Self: ...
    @property
    def columns(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def weight(self) -> float: ...
    @property
    def centered(self) -> bool: ...
    @property
    def exact(self) -> bool: ...
    @property
    def is_extended(self) -> bool: ...
    @property
    def dtype(self) -> str: ...
    @property
    def mean(self) -> Array: ...
    def _add(
        self,
        rows: ArrayLike,
        weights: Optional[ArrayLike],
        products: Products,
        progress: Callback,
    ) -> None: ...
    def _add_file(
        self,
        path: Path,
        weights: Optional[ArrayLike],
        products: Products,
        progress: Callback,
    ) -> List[str]: ...
    def _remove(
        self,
        rows: ArrayLike,
        weights: Optional[ArrayLike],
        products: Products,
        progress: Callback,
    ) -> None: ...
    def _merge(self, other: Accumulator) -> None: ...
    def _result(self, alpha: float, part: str) -> Array: ...
    def _cov(self, ddof: float) -> Array: ...
    def _extended(self, threads: Optional[int]) -> Tuple[List[Array], bool]: ...
    def _lstsq(self, targets: int, options: Dict[str, Any]) -> Dict[str, Any]: ...
    def _pca(
        self,
        components: Union[int, float, None],
        standardize: bool,
        whiten: bool,
        threads: Optional[int],
    ) -> Dict[str, Any]: ...
    def _save(self, path: Path) -> None: ...
    def _load(self, path: Path) -> None: ...
    def _to_bytes(self) -> bytes: ...
    def _restore(self, bytes: bytes) -> None: ...

class Eigenbasis:
    def __new__(
        cls, values: ArrayLike, functions: ArrayLike, mass: Any, pieces: Pieces
    ) -> Self: ...
    @property
    def _pieces(self) -> Pieces: ...
    def __len__(self) -> int: ...
    @property
    def values(self) -> Array: ...
    @property
    def functions(self) -> Array: ...
    def _mass(self) -> Csr: ...
    def _filter(
        self, f: ArrayLike, gains: ArrayLike, rest: float, threads: Optional[int]
    ) -> Array: ...
    def _add_coefficient(self, f: ArrayLike, index: int, amount: float) -> Array: ...
    def _point_signature(self) -> Array: ...
    def _heat_signature(
        self, times: Optional[ArrayLike], count: int, threads: Optional[int]
    ) -> Tuple[Array, Array]: ...
    def _wave_signature(self, count: int, threads: Optional[int]) -> Tuple[Array, Array]: ...

class MetricHandle:
    def __new__(
        cls,
        spectra: ArrayLike,
        identities: List[int],
        errors: Optional[ArrayLike],
        zeros: int,
        scale_free: bool,
        shrinkage: float,
        poses_only: bool,
        spectrum: str,
    ) -> Self: ...
    @staticmethod
    def from_bytes(content: bytes) -> MetricHandle: ...
    @staticmethod
    def read(path: Path) -> MetricHandle: ...
    def to_bytes(self) -> bytes: ...
    def write(self, path: Path) -> None: ...
    def distances(self, queries: ArrayLike, shapes: ArrayLike) -> Array: ...
    @property
    def k(self) -> int: ...
    @property
    def spectrum(self) -> str: ...

class CholeskyHandle:
    def __new__(
        cls,
        a: Csr,
        triangle: str,
        semidefinite: bool,
        tolerance: Optional[float],
        order: Optional[ArrayLike],
        threads: Optional[int],
        progress: Callback,
    ) -> Self: ...
    def factor(self, a: Csr, progress: Callback) -> None: ...
    def solve(self, b: ArrayLike, rows: Optional[ArrayLike], progress: Callback) -> Array: ...
    @property
    def n(self) -> int: ...
    @property
    def entries(self) -> int: ...
    @property
    def held(self) -> Array: ...
    @property
    def weakest(self) -> Optional[Tuple[int, float]]: ...

class PlantHandle:
    def __new__(
        cls,
        tails: ArrayLike,
        radii: ArrayLike,
        parents: ArrayLike,
        leaves: List[bool],
        base: Sequence[float],
        more: List[Tuple[bool, Optional[float], bool]],
    ) -> Self: ...
    def more(self) -> List[Tuple[bool, Optional[float], bool]]: ...
    def notes(self) -> List[str]: ...
    def __len__(self) -> int: ...
    def arrays(self) -> Tuple[Array, Array, Array, Array, Array]: ...

def ata(
    a: Any,
    b: Any,
    weights: Optional[ArrayLike],
    center: Any,
    out: Optional[Array],
    alpha: float,
    beta: float,
    products: Products,
    wide: bool,
    progress: Callback,
) -> Array: ...
def ata_sparse(
    a: Csr,
    weights: Optional[ArrayLike],
    center: Any,
    out: Optional[Array],
    alpha: float,
    beta: float,
    products: Products,
    progress: Callback,
) -> Array: ...
def verify(
    a: Any,
    c: ArrayLike,
    weights: Optional[ArrayLike],
    center: Any,
    alpha: float,
    part: str,
    rounds: int,
    seed: int,
) -> Tuple[bool, float, float, float]: ...
def plan(m: int, n: int, k: Optional[int], scalar: str, products: Products) -> Plan: ...
def lstsq(
    a: ArrayLike,
    b: ArrayLike,
    weights: Optional[ArrayLike],
    options: Dict[str, Any],
    progress: Callback,
) -> Dict[str, Any]: ...
def lstsq_table(
    a: ArrayLike,
    codes: ArrayLike,
    factors: List[Tuple[str, List[str], bool]],
    b: ArrayLike,
    weights: Optional[ArrayLike],
    drop: bool,
    options: Dict[str, Any],
    progress: Callback,
) -> Tuple[Dict[str, Any], List[str], List[int]]: ...
def t_quantile(probability: float, freedom: float) -> float: ...
def pca(
    a: ArrayLike,
    weights: Optional[ArrayLike],
    components: Union[int, float, None],
    standardize: bool,
    whiten: bool,
    threads: Optional[int],
    progress: Callback,
) -> Dict[str, Any]: ...
def scores(rows: Any, of: Any, progress: Callback) -> Array: ...
def svd(a: ArrayLike, threads: Optional[int], progress: Callback) -> Tuple[Array, Array]: ...
def corrcoef(a: ArrayLike, threads: Optional[int], progress: Callback) -> Array: ...
def orthogonality(
    q: ArrayLike, threads: Optional[int], progress: Callback
) -> Tuple[float, float]: ...
def qr(
    a: ArrayLike, mass: Any, threads: Optional[int], progress: Callback
) -> Tuple[Array, Array]: ...
def orthogonalize(
    a: ArrayLike,
    mass: Any,
    method: str,
    threshold: Optional[float],
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Array, Array, Array]: ...
def shape(name: str, counts: Sequence[int], sizes: Sequence[float]) -> Tuple[Array, Array]: ...
def read(path: Path, options: Dict[str, Any], progress: Callback) -> Dict[str, Any]: ...
def read_mesh(path: Path) -> Tuple[Array, Array, Dict[str, Any]]: ...
def read_scalars(path: Path) -> Dict[str, Array]: ...
def mesh_from_bytes(data: bytes, format: str) -> Tuple[Array, Array, Dict[str, Any]]: ...
def mesh_to_bytes(
    v: ArrayLike,
    f: ArrayLike,
    format: str,
    colors: Optional[ArrayLike],
    uv: Optional[ArrayLike],
    text: bool,
) -> Tuple[bytes, List[str]]: ...
def measure(v: ArrayLike, f: ArrayLike, what: str, threads: Optional[int]) -> Any: ...
def validate(v: ArrayLike, f: ArrayLike) -> Dict[str, Any]: ...
def quality(v: ArrayLike, f: ArrayLike) -> Tuple[List[float], int]: ...
def submesh(v: ArrayLike, f: ArrayLike, chosen: ArrayLike) -> PartArrays: ...
def component(v: ArrayLike, f: ArrayLike, number: int) -> PartArrays: ...
def compare(
    first: Any, second: Any, threads: Optional[int]
) -> List[Tuple[float, float, float]]: ...
def difference(first: Any, second: Any, threads: Optional[int]) -> List[float]: ...
def isosurface(
    values: ArrayLike, level: float, lattice: Dict[str, Any], progress: Callback
) -> MeshArrays: ...
def label_surface(mask: Array, lattice: Dict[str, Any], progress: Callback) -> MeshArrays: ...
def cut(v: ArrayLike, f: ArrayLike, along: ArrayLike) -> PartArrays: ...
def enclosed_faces(
    v: ArrayLike, f: ArrayLike, along: ArrayLike, side: str, seeds: Optional[ArrayLike]
) -> Array: ...
def region_boundary(v: ArrayLike, f: ArrayLike, region: Array) -> Array: ...
def cloud_laplacian(
    points: ArrayLike,
    neighbours: int,
    boundary: Any,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Csr, Csr, Array]: ...
def gradient(v: ArrayLike, f: ArrayLike, diverges: bool) -> Csr: ...
def dirichlet_energies(functions: ArrayLike, stiffness: Csr, mass: Any) -> Array: ...
def shot(
    v: ArrayLike, f: ArrayLike, radius: float, threads: Optional[int], progress: Callback
) -> Array: ...
def geodesic_rings(
    v: ArrayLike,
    f: ArrayLike,
    functions: ArrayLike,
    radius: float,
    rings: int,
    threads: Optional[int],
    progress: Callback,
) -> Array: ...
def write_mesh(
    path: Path,
    v: ArrayLike,
    f: ArrayLike,
    colors: Optional[ArrayLike],
    uv: Optional[Array],
    overwrite: bool,
    text: bool,
) -> List[str]: ...
def laplacian(
    v: ArrayLike,
    f: ArrayLike,
    kind: str,
    mass: str,
    boundary: Any,
    weld: bool,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Csr, Csr, Array]: ...
def eigsh(
    v: ArrayLike,
    f: ArrayLike,
    search: Dict[str, Any],
    kind: str,
    mass: str,
    boundary: Any,
    weld: bool,
    progress: Callback,
) -> Tuple[Tuple[Array, Array], Pieces]: ...
def eigsh_sparse(
    a: Csr, mass: Any, search: Dict[str, Any], progress: Callback
) -> Tuple[Tuple[Array, Array], int]: ...
def count_below_sparse(a: Csr, mass: Any, value: float) -> int: ...
def count_below_mesh(
    v: ArrayLike,
    f: ArrayLike,
    kind: str,
    mass: str,
    boundary: Any,
    weld: bool,
    threads: Optional[int],
    value: float,
) -> int: ...
def free_components_sparse(a: Csr, mass: Any) -> int: ...
def free_components_mesh(v: ArrayLike, f: ArrayLike, boundary: Any, weld: bool) -> int: ...
def eigenbasis(
    v: Any,
    f: Any,
    k: int,
    kind: str,
    weld: bool,
    threads: Optional[int],
    progress: Callback,
) -> BasisParts: ...
def eigsh_ranks(a: Csr, mass: Any, search: Dict[str, Any], comm: int) -> Tuple[Array, Array]: ...
def eigenproducts(
    basis: Eigenbasis, order: int, method: str, threads: Optional[int], progress: Callback
) -> Tuple[Array, Array, Array, List[List[int]]]: ...
def functional_map(
    source: Eigenbasis,
    target: Eigenbasis,
    meshes: Optional[Tuple[Tuple[Any, Any], Tuple[Any, Any]]],
    k: Tuple[int, int],
    landmarks: Optional[ArrayLike],
    functions: Optional[Tuple[ArrayLike, ArrayLike]],
    signatures: bool,
    commutativity: float,
    refine: str,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Array, Array, Optional[str]]: ...
def product_map(
    source: Eigenbasis,
    target: Eigenbasis,
    map: ArrayLike,
    order: int,
    method: str,
    all: bool,
    threads: Optional[int],
    progress: Callback,
) -> Array: ...
def transfer(
    source: Eigenbasis,
    target: Eigenbasis,
    functions: ArrayLike,
    points: ArrayLike,
    k: Tuple[int, int],
    order: int,
    method: str,
    threads: Optional[int],
    progress: Callback,
) -> Array: ...
def distances(
    v: ArrayLike,
    f: ArrayLike,
    sources: ArrayLike,
    weights: Optional[ArrayLike],
    method: str,
    time: float,
    kind: str,
    threads: Optional[int],
    progress: Callback,
) -> Array: ...
def geodesic_path(
    v: ArrayLike,
    f: ArrayLike,
    through: ArrayLike,
    weights: Optional[ArrayLike],
    progress: Callback,
) -> Tuple[Array, Array, Array, float]: ...
def trace_geodesic(
    v: ArrayLike,
    f: ArrayLike,
    start: int,
    direction: ArrayLike,
    length: float,
    weights: Optional[ArrayLike],
    progress: Callback,
) -> Tuple[Tuple[Array, Array, Array, float], str, Array]: ...
def shortest_path(
    v: ArrayLike, f: ArrayLike, start: int, end: int
) -> Tuple[Array, Array, float]: ...
def repair(
    v: ArrayLike, f: ArrayLike, steps: Dict[str, Any], progress: Callback
) -> Tuple[Tuple[Array, Array], Array, List[str]]: ...
def transfer_details(
    source_mesh: Any,
    target_mesh: Any,
    source: Eigenbasis,
    target: Eigenbasis,
    smooth: int,
    points: ArrayLike,
    k: Tuple[int, int],
    order: int,
    method: str,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Array, Array]: ...
def shape_from_spectrum(
    v: ArrayLike,
    f: ArrayLike,
    eigenvalues: ArrayLike,
    steps: int,
    tolerance: float,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Tuple[Array, Array], Array, float, int]: ...
def interpolate_spectra(first: ArrayLike, second: ArrayLike, t: float) -> Array: ...
def locate_union(
    parts: List[Any],
    v: Any,
    f: Any,
    model: Optional[Path],
    weld: bool,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Array, List[Optional[Pieces]]]: ...
def decimate(
    v: ArrayLike,
    f: ArrayLike,
    n: Optional[int],
    error: Optional[float],
    how: Dict[str, Any],
    progress: Callback,
) -> Tuple[Array, Array, Array, Array, Csr, int]: ...
def farthest_points(
    v: ArrayLike, f: ArrayLike, n: int, first: Optional[int], progress: Callback
) -> Tuple[Array, Array, Array]: ...
def curve(
    v: ArrayLike,
    f: ArrayLike,
    samples: ArrayLike,
    how: Dict[str, Any],
    smooth: bool,
    progress: Callback,
) -> FoundCurves: ...
def draw(
    v: ArrayLike,
    f: ArrayLike,
    layers: List[Tuple[ArrayLike, Dict[str, Any]]],
    smooth: bool,
    progress: Callback,
) -> Tuple[RefinedArrays, List[FoundCurves]]: ...
def place(
    v: ArrayLike, f: ArrayLike, of_faces: ArrayLike, barycentric: ArrayLike, insert: bool
) -> Tuple[RefinedArrays, Array]: ...
def shape_dna(
    v: ArrayLike,
    f: ArrayLike,
    k: int,
    normalized: bool,
    kind: str,
    weld: bool,
    threads: Optional[int],
    progress: Callback,
) -> Tuple[Array, Pieces]: ...
def union_spectrum(
    parts: List[Any], model: Optional[Path], weld: bool, progress: Callback
) -> Tuple[Array, List[Array], List[Optional[Pieces]], float]: ...
def read_plant(
    path: Path, individual: Optional[str], unit: Tuple[float, float]
) -> PlantHandle: ...
def grow(nodes: int, seed: int) -> PlantHandle: ...
def wilt(
    plant: PlantHandle, weather: Dict[str, Any], progress: Callback
) -> Tuple[Array, Array, Array, Array, Array, List[List[Array]]]: ...
def tubes(
    plant: PlantHandle, pose: List[Array], sides: int, thinnest: float
) -> Tuple[Array, Array]: ...
def slime(
    v: ArrayLike,
    f: ArrayLike,
    steps: int,
    mould: Dict[str, Any],
    uv: Optional[Array],
    start: Optional[ArrayLike],
    ground: Optional[ArrayLike],
    progress: Callback,
) -> Tuple[Array, Array, Array, int]: ...
def newton(
    at: Dict[str, Any], fractal: Dict[str, Any], progress: Callback
) -> Tuple[Array, Array, int]: ...
