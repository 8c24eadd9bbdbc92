"""Scenes."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _leafwise
from ._arrays import Array, count, in_order, listed, number, real_numbers, reals
from ._arrays import table as of_names
from ._commands import command
from ._comparison import Comparison
from ._ensemble import Ensemble
from ._errors import IntegrationError, LeafwiseError, LeafwiseWarning, SceneError
from ._fit import Fit, fit
from ._gradient import Trajectory
from ._functions import System
from ._keys import key_of
from ._leafwise import Integrator, table_of_text, text_of, text_of_value
from ._progress import shown
from ._run import Run
from ._shards import AskedEnsemble, AskedSweep
from ._shards import ensemble as ensemble_of_shards
from ._shards import sweep as sweep_of_shards
from ._state_error import StateError
from ._sweep import Sweep
from ._views import text_of_scene

#: More threads than any machine of these years has.
_MOST_THREADS = 1024


class Scene:
    """A system, a method and a plan: what a scene file says.

    ``Scene({"system": ..., "method": ..., "run": ...})`` or ``Scene(system=..., method=..., run=...)``; arrays are
    lists, and a system may be a :class:`System` of functions. ``Scene.load`` reads a file, ``Scene.parse`` a text.

    A table of ``system["tables"]`` takes its numbers as ``values``, an array with an axis for each of its ``axes``, instead of a file:
    ``"tables": {"psi": {"values": psi, "axes": {"R": [0.8, 1.2], "Z": [-0.2, 0.2]}}}``.

    Tables, keys and kinds of values are checked here. Formulas, names and parts are checked when the scene is composed. That is at its
    first property, such as ``variables``, its first run, or anything else that needs the system.

    Raises:
        SceneError: each problem with its place.
        TypeError: a value that no scene holds, such as a complex number, or a table that holds itself.
    """

    def __init__(self, table: Mapping[str, Any] | None = None, /, **sections: Any) -> None:
        whole = {**of_names("a scene", table), **sections}
        if not whole:
            raise TypeError("a scene needs sections: Scene(system=..., method=..., run=...)")
        system = whole.get("system")
        functions = system if isinstance(system, System) else None
        if functions:
            whole["system"] = {"library": "python/functions"}
        whole, arrays = _without_arrays(whole)
        self._hold(_leafwise.Scene(text_of(whole), "scene.toml", [], functions, arrays))

    def _hold(self, scene: _leafwise.Scene) -> None:
        self._scene = scene
        self._retraced: _leafwise.Retraced | None = None
        self._described: tuple[list[str], list[str], list[tuple[str, float]], list[str]] | None = None

    @classmethod
    def parse(
        cls,
        text: str,
        name: str = "scene.toml",
        set: Mapping[str, Any] | None = None,
        tables: Mapping[str, ArrayLike] | None = None,
    ) -> Scene:
        """The scene of a text; ``set`` overrides values, as in ``{"method.epsilon": 0.05}``.

        ``tables`` are the numbers of its ``[system.tables]`` instead of files, an array with an axis for each of the table's.
        """
        if not isinstance(text, str):
            raise TypeError(f"a scene's text is a string, not {type(text).__name__}: Scene(...) takes tables, Scene.load a file")
        return cls._of(text, name, _overrides(of_names("set", set)), None, _arrays(tables))

    @classmethod
    def load(
        cls,
        file: str | PathLike[str],
        set: Mapping[str, Any] | None = None,
        tables: Mapping[str, ArrayLike] | None = None,
    ) -> Scene:
        """The scene of a file; ``set`` and ``tables`` as in :meth:`parse`."""
        path = Path(file)
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            raise LeafwiseError(f"{path} is not UTF-8 text") from None
        return cls._of(text, fspath(path), _overrides(of_names("set", set)), None, _arrays(tables))

    @classmethod
    def _of(
        cls,
        text: str,
        name: str,
        overrides: list[tuple[str, str]],
        system: System | None,
        arrays: list[tuple[str, Array]],
    ) -> Scene:
        scene = cls.__new__(cls)
        scene._hold(_leafwise.Scene(text, name, overrides, system, arrays))
        return scene

    def __reduce__(self) -> tuple[Any, ...]:
        return Scene._of, self._scene.origin

    def set(self, **values: Any) -> Scene:
        """The same scene with other values: ``scene.set(run__steps=100, method={"stepper": "rk4", "time-step": 0.1})``.

        Two underscores stand for a dot, and ``method__time_step`` for ``method.time-step``; a table, or its text in TOML, takes the place
        of the whole table. Where initial state, step, number of steps and samples are all that differs, both scenes share their method.
        """
        pairs = {key_of(key): _section(key, value) for key, value in values.items()}
        scene = Scene.__new__(Scene)
        scene._hold(self._scene.set(_overrides(pairs)))
        return scene

    @property
    def name(self) -> str:
        """The file's name."""
        return self._scene.name

    @property
    def text(self) -> str:
        """The scene as TOML."""
        return self._scene.text

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def _identity(self) -> tuple[str, Path, int, tuple[tuple[str, tuple[int, ...], bytes], ...]]:
        """Text of the scene, folder of its files, functions and arrays: equal for equal scenes."""
        origin = self._scene.origin
        arrays = tuple((name, array.shape, array.tobytes()) for name, array in origin[4])
        return self.text, Path(self.name).parent, id(origin[3]), arrays

    def _description(self) -> tuple[list[str], list[str], list[tuple[str, float]], list[str]]:
        if self._described is None:
            self._described = self._scene.describe()
        return self._described

    @property
    def variables(self) -> list[str]:
        """The names of the coordinates."""
        return self._description()[0]

    @property
    def casimirs(self) -> list[str]:
        """The names of the Casimirs."""
        return self._description()[1]

    @property
    def parameters(self) -> dict[str, float]:
        """The parameters' values."""
        return dict(self._description()[2])

    @property
    def method(self) -> list[str]:
        """The method in words."""
        return self._description()[3]

    def run(
        self,
        *,
        steps: int | None = None,
        until: float | None = None,
        record: int | None = None,
        initial: Any = None,
        parameters: Mapping[str, float] | None = None,
        advice: bool = True,
        allow_non_poisson: bool = False,
        progress: bool | Callable[[int, int], object] | None = None,
    ) -> Run:
        """Step the scene, with every sample in memory: the same numbers as the program's.

        Args:
            steps: the number of steps.
            until: the time at the end, in place of steps, where the scene has a pace.
            record: every how many steps a sample is kept.
            initial: the initial state, shape (d,), or a number for each name.
            parameters: parameters by name. The method is that of the scene's own values, as members of an ensemble have it: it is composed
                once for all calls.
            advice: look for what to change in the scene and warn of it. It builds other methods to compare with: leave it out in loops.
            allow_non_poisson: step a tensor that violates the Jacobi identity.
            progress: a function of the steps made and their number; True for a bar on standard error, False for none. By default
                there is a bar on terminals, in long runs.

        Ctrl-C ends the run and returns what was recorded, with the outcome ``interrupted`` and a warning.

        Raises:
            SceneError: the scene is not valid.
            IntegrationError: a step could not be taken; its ``run`` holds what was recorded before.
            MemoryError: the samples take more memory than there is, found before the first step where their number is known: keep
                fewer by ``record``. Where it is found later, its ``run`` holds what was recorded before.
            TypeError, ValueError: an argument is none.
        """
        overrides = _overrides(
            {
                "run.steps": None if steps is None else count("steps", steps, 0),
                "run.until": None if until is None else number("until", until),
                "run.record.every": None if record is None else count("record", record, 1),
                "run.initial": initial,
            }
        )
        return self._run(overrides, _values(parameters), [], advice, allow_non_poisson, progress)

    def _run(
        self,
        overrides: list[tuple[str, str]],
        parameters: list[tuple[str, float]],
        events: Sequence[tuple[str, str, int | None]],
        advice: bool,
        allow_non_poisson: bool,
        progress: bool | Callable[[int, int], object] | None,
    ) -> Run:
        with shown(progress) as told:
            recorded = self._scene.run(overrides, parameters, list(events), not advice, allow_non_poisson, told)
        run = Run(recorded)
        for line in run.warnings:
            warnings.warn(line, LeafwiseWarning, stacklevel=3)
        if run.outcome == "interrupted":
            warnings.warn(run.message, LeafwiseWarning, stacklevel=3)
        if recorded.no_state_error is not None:
            warnings.warn(f"error not estimated: {recorded.no_state_error}", LeafwiseWarning, stacklevel=3)
        if recorded.has_no_room:
            lost = MemoryError(run.message)
            lost.run = run  # type: ignore[attr-defined]
            raise lost
        if run.outcome == "failed":
            error = IntegrationError(run.message)
            error.run = run
            raise error
        return run

    def ensemble(
        self,
        x0: ArrayLike | None = None,
        parameters: Mapping[str, ArrayLike] | None = None,
        *,
        steps: int | None = None,
        record: int | None = None,
        quantiles: ArrayLike | None = None,
        threads: int | None = None,
        executor: Any = None,
        shards: int | None = None,
        allow_non_poisson: bool = False,
        progress: bool | Callable[[int, int], object] | None = None,
    ) -> Ensemble:
        """Step many members side by side on all threads, without a trajectory in memory: the same numbers as the program's.

        Args:
            x0: the members' initial states, shape (n, d), the columns of a frame by their names; the scene's own where not given.
            parameters: parameters by name with a value for each member, shape (n,) each. Where neither is given, members are
                those of the scene's ``[ensemble]``.
            steps: the number of steps.
            record: every how many steps statistics are taken, beside the first and the last.
            quantiles: what parts of the members lie below the quantiles in the statistics, shape (k,).
            threads: how many threads; no result depends on it. A worker of an executor has one where not given.
            executor: where shards of the ensemble are stepped: anything with ``submit`` of ``concurrent.futures``, such as
                ``ProcessPoolExecutor``, ``mpi4py.futures.MPIPoolExecutor``, or a client of Dask. The result is the same; shards are
                joined in groups by the workers, and workers that fail are the executor's to replace. ``progress`` then counts
                shards.
            shards: into how many shards, 4 for each processor of this machine where not given; with an executor alone.
            allow_non_poisson: step a tensor that violates the Jacobi identity.
            progress: as in :meth:`run`, of the members' steps.

        A member that fails ends no other: a warning says how many have, and ``outcomes`` and ``failures`` which. Ctrl-C returns the members that had ended, with a warning.

        Raises:
            SceneError: the scene, or one of the parameters' names, is not valid.
            TypeError, ValueError: an array has another shape or type, or holds a number that is not finite.
        """
        if x0 is None:
            states = None
        else:
            names = self.variables
            states = reals("x0", in_order("x0", x0, names), None, len(names))
        members = None if states is None else len(states)
        varied = {name: reals(name, values, None) for name, values in of_names("parameters", parameters).items()}
        for name, values in varied.items():
            members = len(values) if members is None else members
            if len(values) != members:
                raise ValueError(f"{name} has {len(values)} values for {members} members")
        if members == 0:
            raise ValueError("there are no members")
        overrides = _overrides(
            {
                "run.steps": None if steps is None else count("steps", steps, 0),
                "ensemble.final-states": "csv",
                "ensemble.record.every": None if record is None else count("record", record, 1),
                "ensemble.record.quantiles": None if quantiles is None else reals("quantiles", quantiles, None),
            }
        )
        if members is None and not self._scene.has("ensemble"):
            raise SceneError("there are no members: give x0, parameters or both, or a table [ensemble] with `members` in the scene")
        threads = _threads(threads)
        files = Path(self.name).parent
        if executor is None and shards is not None:
            raise ValueError("shards are made by an executor: give executor= too")
        if executor is not None:
            asked = AskedEnsemble(self._scene.origin, overrides, states, list(varied.items()), files.absolute(), allow_non_poisson)
            with shown(progress) as told:
                return self._told(ensemble_of_shards(asked, executor, _shards(shards), threads or 1, told))
        with tempfile.TemporaryDirectory() as folder, shown(progress) as told:
            out = Path(folder) / "ensemble"
            left = self._scene.ensemble(
                overrides, states, list(varied.items()), files, out, None, threads, allow_non_poisson, told
            )
        return self._told(left)

    @staticmethod
    def _told(left: _leafwise.Ensemble) -> Ensemble:
        ensemble = Ensemble(left)
        for advice in ensemble.warnings:
            warnings.warn(advice, LeafwiseWarning, stacklevel=3)
        if failed := ensemble.failed:
            message = f"{failed} of {len(ensemble)} members failed; statistics cover the others: see failures"
            warnings.warn(message, LeafwiseWarning, stacklevel=3)
        if ensemble.outcome == "interrupted":
            warnings.warn(f"interrupted after {len(ensemble)} members", LeafwiseWarning, stacklevel=3)
        return ensemble

    def sweep(
        self,
        grid: Mapping[str, Any] | None = None,
        *,
        settings: Sequence[Mapping[str, Any]] | None = None,
        observables: Sequence[str | Mapping[str, str]] | None = None,
        steps: int | None = None,
        threads: int | None = None,
        executor: Any = None,
        shards: int | None = None,
        allow_non_poisson: bool = False,
        progress: bool | Callable[[int, int], object] | None = None,
    ) -> Sweep:
        """Run the scene for each of many settings of its keys, on all threads: the same numbers as single runs.

        Args:
            grid: keys with their values, all combinations of which are run: ``{"method.time-step": [0.1, 0.2]}``, or
                ``{"range": [from, to, count]}`` and ``{"logarithmic": [from, to, count]}`` for the values.
            settings: in place of a grid, settings one by one, each a mapping of keys to values. Where neither is given,
                settings are those of the scene's ``[sweep]``.
            observables: what is measured of each last state, as the scene's ``record``; beside grid or settings alone.
            steps: the number of steps of settings that do not name it.
            threads: how many threads; no result depends on it. A worker of an executor has one where not given.
            executor: where shards of the sweep are run, as in :meth:`ensemble`; ``progress`` then counts shards.
            shards: into how many shards, 4 for each processor of this machine where not given; with an executor alone.
            allow_non_poisson: step a tensor that violates the Jacobi identity.
            progress: as in :meth:`run`, of the steps of all settings.

        A setting whose run fails is a row, with the reason in ``errors``. Ctrl-C returns the settings that had ended, with a warning.

        Raises:
            SceneError: a setting whose scene is not valid; nothing has been run then.
        """
        if grid is not None and settings is not None:
            raise ValueError("give grid or settings, not both")
        if observables is not None and grid is None and settings is None:
            raise ValueError("observables need grid or settings: those of the scene's own sweep are in its table")
        overrides = [] if steps is None else _overrides({"run.steps": count("steps", steps, 0)})
        if grid is not None or settings is not None:
            swept: dict[str, Any] = (
                {"list": [of_names("a setting", one) for one in listed("settings", settings)]}
                if settings is not None
                else {"grid": of_names("grid", grid)}
            )
            if observables is not None:
                swept["record"] = {"observables": listed("observables", observables)}
            overrides += _overrides({"sweep": swept})
        elif not self._scene.has("sweep"):
            raise SceneError("there are no settings, and the scene has no [sweep] table: give grid or settings")
        threads = _threads(threads)
        if executor is None and shards is not None:
            raise ValueError("shards are made by an executor: give executor= too")
        with shown(progress) as told:
            if executor is not None:
                asked = AskedSweep(self._scene.origin, overrides, allow_non_poisson)
                left = sweep_of_shards(asked, executor, _shards(shards), threads or 1, told)
            else:
                with tempfile.TemporaryDirectory() as folder:
                    out = Path(folder) / "sweep"
                    left = self._scene.sweep(overrides, out, None, threads, allow_non_poisson, told)
        sweep = Sweep(left)
        if sweep.failed:
            message = f"{sweep.failed} of {len(sweep)} settings failed: see errors"
            warnings.warn(message, LeafwiseWarning, stacklevel=2)
        if sweep.outcome == "interrupted":
            warnings.warn(f"interrupted after {len(sweep)} settings", LeafwiseWarning, stacklevel=2)
        return sweep

    def integrator(
        self, *, initial: Any = None, parameters: Mapping[str, float] | None = None, allow_non_poisson: bool = False
    ) -> Integrator:
        """The method's steps from the initial state, for your loop; ``initial`` and ``parameters`` are those of :meth:`run`.

        Raises:
            SceneError: the scene is not valid, or its bracket is not Poisson and ``allow_non_poisson`` is not given.
        """
        return self._scene.integrator(_overrides({"run.initial": initial}), _values(parameters), allow_non_poisson)

    def state_error(
        self, *, steps: int | None = None, until: float | None = None, initial: Any = None, parameters: Mapping[str, float] | None = None
    ) -> StateError:
        """Estimate the error of the run's states by a pass with half the step, in the maximum norm; arguments are those of :meth:`run`.

        A method of order m errs by C tᵐ, so two passes differ by 1 − 2⁻ᵐ of the error. It takes three times the steps of the run.

        Raises:
            LeafwiseError: there is no estimate: noise, a pace, a method whose tolerance sets its error, or a step that fails.
        """
        overrides = _overrides(
            {
                "run.steps": None if steps is None else count("steps", steps, 0),
                "run.until": None if until is None else number("until", until),
                "run.initial": initial,
            }
        )
        return StateError(*self._scene.state_error(overrides, _values(parameters)))

    def _states(self) -> _leafwise.Retraced | None:
        """The states of its run at any times, where they are known from its steps."""
        if self._retraced is None:
            self._retraced = self._scene.retraced()
        return self._retraced

    def trajectory(
        self,
        parameters: Sequence[str] | None = None,
        *,
        steps: int | None = None,
        record: int | None = None,
        allow_non_poisson: bool = False,
    ) -> Trajectory:
        """The samples as a differentiable function of the initial state and these parameters.

        Where none are named they are all but those that values of sites are formed of.
        """
        return Trajectory(self, parameters, steps=steps, record=record, allow_non_poisson=allow_non_poisson)

    def fit(
        self,
        data: ArrayLike,
        parameters: Sequence[str],
        *,
        sigma: ArrayLike | None = None,
        observed: Sequence[str] | None = None,
        record: int | None = None,
        initial: bool = False,
        iterations: int = 50,
        times: ArrayLike | None = None,
        bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
        priors: Mapping[str, tuple[float, float]] | None = None,
    ) -> Fit:
        """Parameters from noisy observations, by Gauss and Newton's method with exact derivatives.

        Args:
            data: the observations, shape (n, m): a row for each sample, the first at t = 0; NaN or masked where nothing was observed.
                Columns of a frame go by their names where these are coordinates.
            parameters: the parameters to find, from the scene's own values on.
            sigma: the standard deviation of the noise: a number, or shape (m,) or (n, m). Where it is not given it is
                taken from the residuals, the same for all data.
            observed: the coordinates that the columns are of; all where none are named.
            record: every how many steps there is an observation; the scene's own where not given.
            initial: find the initial state too, from the scene's own on.
            iterations: at most so many.
            times: the times of the rows, shape (n,), in their order from t = 0 on, where these are no steps. States there are ends of
                shorter steps of the method. ``record`` and the scene's number of steps then say nothing.
            bounds: the least and the largest value of what is fitted, by name: ``{"k": (0, None), "q(0)": (-1, 1)}``. A value that ends
                on its bound has no standard deviation.
            priors: what was known before, by name: the mean of a normal distribution and its standard deviation. Needs sigma.

        Raises:
            LeafwiseError: the data do not determine what is to be found, or the method's derivatives are not known.
            IntegrationError: a step could not be taken at the scene's own values.
        """
        return fit(
            self,
            data,
            parameters,
            sigma=sigma,
            observed=observed,
            record=record,
            initial=initial,
            iterations=iterations,
            times=times,
            bounds=bounds,
            priors=priors,
        )

    def command(self, name: str, *arguments: str, accept: tuple[int, ...] = (0,)) -> Any:
        """The object of a command on this scene: ``scene.command("evaluate", "--at", ...)``. Commands know no functions of Python."""
        if self._scene.origin[3] is not None:
            raise LeafwiseError(f"`{name}` works on scenes of formulas and plugins, and this system is functions of Python")
        tables = self._scene.origin[4]
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / (Path(self.name).name or "scene.toml")
            file.write_text(self.text, encoding="utf-8")
            for table, values in tables:
                # Its numbers in the place of the text's own.
                numbers = Path(folder) / f"{table}.npy"
                np.save(numbers, values)
                arguments = (*arguments, "--set", f"system.tables.{table}.file={fspath(numbers)}")
            found = command(name, file, *arguments, accept=accept)
        if isinstance(found, dict) and found.get("scene") == fspath(file):
            found["scene"] = self.name
        return found

    def check(self) -> dict[str, Any]:
        """Jacobi identity and Casimirs of the system, as ``leafwise check``. A check that fails is in the result, and raises nothing."""
        found: dict[str, Any] = self.command("check", accept=(0, 5))
        return found

    def verify(self) -> dict[str, Any]:
        """Measure this scene's method and all others on its system against what they declare, as ``leafwise verify``.

        ``["rows"]`` has a row for each; this method's has ``"is_own": True``. ``"met"`` says that no declaration is broken. Nothing is raised.
        """
        found: dict[str, Any] = self.command("verify", accept=(0, 5))
        return found

    def compare(self, *arguments: str) -> Comparison:
        """Cost against accuracy of methods on this scene, as ``leafwise compare``: ``scene.compare("--at-end").to_pandas()``."""
        return Comparison(self.command("compare", *arguments))

    def tune(self, error: float, *arguments: str) -> dict[str, Any]:
        """The cheapest method and step for an error, as ``leafwise tune --error``."""
        found: dict[str, Any] = self.command("tune", "--error", repr(number("error", error)), *arguments)
        return found

    def tuned(self, error: float, *arguments: str) -> Scene:
        """The same scene with the cheapest method and step for an error, which :meth:`tune` finds."""
        best = self.tune(error, *arguments)["recommended"]
        if best is None:
            raise LeafwiseError(f"no method is known that errs by at most {error:g}: see scene.tune({error:g})")
        return self.set(method=best["method"], run__steps=best["steps"])

    def _repr_html_(self) -> str:
        return text_of_scene(self)

    def __repr__(self) -> str:
        return f"<leafwise.Scene {self.name}>"


def _shards(asked: int | None) -> int:
    """How many shards; 4 for each processor of this machine where not said."""
    return 4 * (os.cpu_count() or 1) if asked is None else count("shards", asked, 1)


def _threads(asked: int | None) -> int | None:
    """How many threads; more than a machine has take turns, and no result depends on them."""
    return None if asked is None else min(count("threads", asked, 1), _MOST_THREADS)


def _values(parameters: Mapping[str, float] | None) -> list[tuple[str, float]]:
    """Parameters by name as doubles."""
    return [(name, number(name, value)) for name, value in of_names("parameters", parameters).items()]


def _section(name: str, value: Any) -> Any:
    """A table of a scene, where its text stands for it."""
    return table_of_text(name, value) if isinstance(value, str) and "=" in value and "__" not in name else value


def _arrays(tables: Mapping[str, ArrayLike] | None) -> list[tuple[str, Array]]:
    """The numbers of tables by their names."""
    given = of_names("tables", tables)
    return [(name, np.ascontiguousarray(real_numbers(f"tables[{name!r}]", values))) for name, values in given.items()]


def _without_arrays(whole: dict[str, Any]) -> tuple[dict[str, Any], list[tuple[str, Array]]]:
    """The scene with the numbers of its tables beside it."""
    system = whole.get("system")
    tables = system.get("tables") if isinstance(system, Mapping) else None
    if not isinstance(system, Mapping) or not isinstance(tables, Mapping):
        return whole, []
    rest: dict[str, Any] = {}
    values: dict[str, Any] = {}
    for name, table in tables.items():
        if isinstance(table, Mapping) and "values" in table:
            values[name] = table["values"]
            table = {key: value for key, value in table.items() if key != "values"}
        rest[name] = table
    return {**whole, "system": {**system, "tables": rest}}, _arrays(values)


def _overrides(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Keys and values as TOML, without values of None."""
    return [(key, text_of_value(key, value)) for key, value in values.items() if value is not None]
