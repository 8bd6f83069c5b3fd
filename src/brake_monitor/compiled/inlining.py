"""Functions that are put in where they are called.

numba optimises each of them and makes machine code of it as if it were called by itself too, which none is: four
fifths of the time that a core takes to be compiled. What they are put into is optimised as a whole all the same.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class Inlined(Compiler):  # type: ignore[misc] # numba is not typed
    """Compiles one of them as far as whoever calls it needs."""

    def define_pipelines(self) -> Any:
        """As numba does, into a library of ours."""
        state = self.state
        state.library = _Unfinished(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().define_pipelines()


class _Unfinished(JITCodeLibrary):  # type: ignore[misc]
    """What such a function consists of, for others to link in."""

    def finalize(self) -> None:
        """With what it calls itself, as it stands."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def get_pointer_to_function(self, _: str) -> int:
        """None: it has no machine code ..."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> "_Unfinished":
        """... and no environment, which a code generator would set."""
        return self

    def set_env(self, name: str, env: Any) -> None:
        """See `codegen`."""
