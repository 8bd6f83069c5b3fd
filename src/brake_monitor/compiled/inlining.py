"""Functions that are put in where they are called.

numba would optimise each function and make machine code of it as if it were also called by itself, which none is. That
is four fifths of the time to compile a core. The function that they are put into is optimised as a whole all the same.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class Inlined(Compiler):  # type: ignore[misc] # numba is not typed
    """Compiles such a function only as far as its callers need."""

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
