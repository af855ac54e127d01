"""The run folder: what is finished is kept, what depends on a change is made again.

Every product carries a stamp of all it was made from (inputs by content, options, the program's version).
Asking for a product whose stamp is already on disk loads it; otherwise it is built, written to a temporary
name and renamed.  So an interrupted run resumes, and a changed option invalidates exactly what depends on it.
"""

import contextlib
import json
import time
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.files import unwritable, write_json, write_text

_UNREADABLE = (FileNotFoundError, zipfile.BadZipFile, EOFError, ValueError, KeyError)
"""What loading a product raises where someone has tidied up or a power cut has left half of it."""

VERSION = "4"  # raise it when a stage's algorithm changes, so that old products are not taken for new ones


@dataclass(frozen=True)
class Product[T]:
    """A stage's result and the stamp of everything it depends on."""

    value: T
    stamp: str

    @staticmethod
    def of[V](value: V, *origin: object, root: Path | None = None) -> "Product[V]":
        """A part of a larger product, with a stamp of its own: of the part and where it comes from.

        Files inside ``root``, the run folder, count by their place in it.
        """
        return Product(value, store.stamp(VERSION, value, *origin, root=root))


class RunFolder:
    """One run on disk.

    Args:
        path: the folder; made if missing.
        fresh: names of the stages that must be made again even if they are finished.
        only: names of the stages that may run (None: all); a missing product of another stage is an error.
        before_making: called before a product is made or made again: what rests on the products is outdated.
        root: files inside it are named by their place in it, so that it can be moved; None: ``path``.

    Raises:
        StageError: the folder cannot be written.
    """

    def __init__(
        self,
        path: Path,
        fresh: frozenset[str] = frozenset(),
        only: frozenset[str] | None = None,
        before_making: Callable[[], None] | None = None,
        root: Path | None = None,
    ) -> None:
        self.path = path.absolute()
        self.root = self.path if root is None else root.absolute()
        self._before_making = before_making
        self._fresh = fresh
        self._only = only
        self._made: set[Path] = set()
        self.timing_s: dict[str, float] = {}
        self._writing = Lock()
        try:
            (self.path / "products").mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StageError(
                "run", f"cannot write to {path} ({error.strerror})", "choose another --out folder"
            ) from error
        self._load_timing()

    def block(self, name: str) -> Path:
        """The folder of one block's own files.

        Raises:
            StageError: it cannot be made.
        """
        folder = self.path / "blocks" / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise unwritable(folder, error, "run") from error
        return folder

    def product[T](
        self, stage: str, kind: type[T], build: Callable[[], T], *needs: object, block: str = ""
    ) -> Product[T]:
        """The finished product of a stage, from disk if nothing it needs has changed.

        Args:
            stage: name of the stage.
            kind: the frozen dataclass that ``build`` returns.
            build: makes the product; called only when needed.
            *needs: everything the product depends on: Products (by their stamp) and plain frozen values.
            block: name of the block, for stages that work block by block.
        """
        wanted = store.stamp(
            VERSION,
            stage,
            block,
            store.layout(kind),
            *(n.stamp if isinstance(n, Product) else n for n in needs),
        )
        file = self.path / "products" / f"{block or 'all'}-{stage}.npz"
        mark = file.with_suffix(".stamp")
        again = stage in self._fresh and file not in self._made
        if not again and mark.exists() and mark.read_text(encoding="utf-8") == wanted:
            with contextlib.suppress(*_UNREADABLE):
                return Product(store.load(kind, file, self.root), wanted)
        if self._only is not None and stage not in self._only:
            raise StageError(
                "run",
                f"the stage {stage} is not finished in {self.path.name} with this survey and these options",
                "run it first, without --only",
            )
        if self._before_making is not None:
            self._before_making()
        began = time.monotonic()
        mark.unlink(missing_ok=True)
        value = build()
        store.save(value, file, self.root)
        write_text(mark, wanted, "run")
        self._made.add(file)
        self.note_time(stage, block, time.monotonic() - began)
        return Product(value, wanted)

    def stage_seconds(self) -> dict[str, float]:
        """Time that each stage took when it was last made, all blocks together, in the order of making."""
        seconds: dict[str, float] = {}
        for name, value in self.timing_s.items():
            stage = name.partition("/")[0]
            seconds[stage] = round(seconds.get(stage, 0.0) + value, 3)
        return seconds

    def note_time(self, stage: str, block: str, seconds: float) -> None:
        """Remember how long a stage took."""
        with self._writing:
            self.timing_s[f"{stage}/{block}" if block else stage] = round(seconds, 3)
            write_json(self.path / "products" / "timing.json", self.timing_s, "run")

    @contextlib.contextmanager
    def side_by_side(self, stage: str) -> Iterator[None]:
        """Blocks of a stage that are made at the same time share the time that passes."""
        before, began = dict(self.timing_s), time.monotonic()
        yield
        passed = time.monotonic() - began
        made = {n: s for n, s in self.timing_s.items() if n.startswith(f"{stage}/") and s != before.get(n)}
        share = passed / max(sum(made.values()), 1e-9)
        if share < 1:
            for name, seconds in made.items():
                self.note_time(stage, name.partition("/")[2], share * seconds)

    def _load_timing(self) -> None:
        file = self.path / "products" / "timing.json"
        if file.exists():
            with contextlib.suppress(
                ValueError
            ):  # cut off: only the times of the stages not made again are lost
                self.timing_s = json.loads(file.read_text(encoding="utf-8"))
