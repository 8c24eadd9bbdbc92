from collections.abc import Callable
from pathlib import Path
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ._functions import System
from ._run import Run

Array = NDArray[np.float64]

class LeafwiseError(Exception): ...
class SceneError(LeafwiseError): ...

class IntegrationError(LeafwiseError):
    run: Run | None

@final
class Ensemble:
    parameters: list[str]
    variables: list[str]
    observables: list[str]
    invariants: list[str]
    has_times: bool
    time: float
    members: Array
    outcomes: NDArray[np.uint8]
    crossings: Array | None
    ending: str
    advice: list[str]
    page: str

@final
class Integrator:
    def step(self) -> None: ...
    def advance(self, steps: int) -> None: ...
    @property
    def x(self) -> Array: ...
    @property
    def t(self) -> float: ...
    @property
    def steps(self) -> int: ...
    def copy_to(self, target: Array) -> None: ...

@final
class Growth:
    @property
    def logarithm(self) -> float: ...
    @property
    def rate(self) -> float: ...
    @property
    def digits(self) -> float: ...
    @property
    def is_large(self) -> bool: ...

@final
class Map:
    @property
    def initial(self) -> Array: ...
    @property
    def width(self) -> int: ...
    @property
    def time_step(self) -> float: ...
    @property
    def plan(self) -> tuple[int, int]: ...
    @staticmethod
    def pieces(plan: tuple[int, int]) -> int: ...
    def run(self, initial: Array, parameters: Array, plan: tuple[int, int]) -> tuple[Array, Array]: ...
    def reach(self, initial: Array, parameters: Array, steps: int) -> int: ...
    def push_to(
        self,
        initial: Array,
        parameters: Array,
        tangents: Array,
        by_parameters: Array,
        times: Array,
    ) -> tuple[Array, Array]: ...
    def push(
        self,
        initial: Array,
        parameters: Array,
        tangents: Array,
        by_parameters: Array,
        plan: tuple[int, int],
    ) -> tuple[Array, Array, Growth]: ...
    def pull(
        self,
        initial: Array,
        parameters: Array,
        kept: Array,
        cotangents: Array,
        by_parameters: bool,
        plan: tuple[int, int],
    ) -> tuple[Array, Array, Growth, bool]: ...

@final
class Recorded:
    columns: list[str]
    coordinates: int
    samples: Array
    crossings: Array | None
    windows_columns: list[str]
    windows: Array
    final_state: Array
    outcome: str
    has_no_room: bool
    state_error: tuple[float, float, float, bool] | None
    no_state_error: str | None
    message: str
    time: float
    steps: int
    wall_seconds: float
    evaluations: int
    invariants: list[tuple[str, float, float]]
    events: list[tuple[Array, Array]]
    ended_by: int | None
    scene: str
    method: list[str]
    advice: list[str]
    motion: str | None
    def page(self) -> str: ...

@final
class Retraced:
    def at(self, times: Array) -> Array: ...
    @property
    def steps(self) -> int: ...

@final
class Sweep:
    table: str
    ending: str
    page: str

@final
class Scene:
    def __init__(
        self,
        source: str,
        name: str,
        overrides: list[tuple[str, str]],
        system: System | None,
        arrays: list[tuple[str, Array]],
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def text(self) -> str: ...
    @property
    def origin(self) -> tuple[str, str, list[tuple[str, str]], System | None, list[tuple[str, Array]]]: ...
    def has(self, section: str) -> bool: ...
    def describe(self) -> tuple[list[str], list[str], list[tuple[str, float]], list[str]]: ...
    def run(
        self,
        overrides: list[tuple[str, str]],
        parameters: list[tuple[str, float]],
        events: list[tuple[str, str, int | None]],
        is_silent: bool,
        allow_non_poisson: bool,
        progress: Callable[[int, int], object] | None,
    ) -> Recorded: ...
    def set(self, overrides: list[tuple[str, str]]) -> Scene: ...
    def ensemble(
        self,
        overrides: list[tuple[str, str]],
        states: Array | None,
        parameters: list[tuple[str, Array]],
        files: Path,
        out: Path,
        shards: Path | None,
        threads: int | None,
        allow_non_poisson: bool,
        progress: Callable[[int, int], object] | None,
    ) -> Ensemble: ...
    def shard(
        self,
        overrides: list[tuple[str, str]],
        states: Array | None,
        parameters: list[tuple[str, Array]],
        files: Path,
        out: Path,
        place: tuple[int, int],
        shards: Path | None,
        threads: int | None,
        allow_non_poisson: bool,
    ) -> None: ...
    def sweep(
        self,
        overrides: list[tuple[str, str]],
        out: Path,
        shards: Path | None,
        threads: int | None,
        allow_non_poisson: bool,
        progress: Callable[[int, int], object] | None,
    ) -> Sweep: ...
    def sweep_shard(
        self,
        overrides: list[tuple[str, str]],
        out: Path,
        place: tuple[int, int],
        shards: Path | None,
        threads: int | None,
        allow_non_poisson: bool,
    ) -> None: ...
    def integrator(
        self, overrides: list[tuple[str, str]], parameters: list[tuple[str, float]], allow_non_poisson: bool
    ) -> Integrator: ...
    def state_error(
        self, overrides: list[tuple[str, str]], parameters: list[tuple[str, float]]
    ) -> tuple[float, float, float, bool]: ...
    def retraced(self) -> Retraced | None: ...
    def order(self) -> int: ...
    def check_varied(self, names: list[str], begin_there: bool) -> None: ...
    def map(self, allow_non_poisson: bool) -> Map: ...

def command(arguments: list[str]) -> tuple[int, str, str]: ...
def load_plugin(path: str) -> None: ...
def program(arguments: list[str]) -> int: ...
def start_again_by(program: str, arguments: list[str]) -> None: ...
def table_of_text(name: str, text: str) -> dict[str, Any]: ...
def compositions() -> int: ...
def version() -> str: ...
def text_of(table: dict[str, Any]) -> str: ...
def text_of_value(key: str, value: object) -> str: ...
