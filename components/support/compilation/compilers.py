"""Two kinds of compiled kernels: machine code with an entry from Python, and LLVM's intermediate code for other kernels.

What other kernels alone call is contained in these, and optimized with them. Otherwise each function would be optimized once
for itself and once more in each of its callers, and half of the time of a compilation would go into machine code that nothing
calls.

More things save time: see `dead_branch_pruning`, `direct_lowering`, `folded_tuples`, `flag_comparison`, `call_type_cache` and
`registry_refresh`.

All of this stands on the inside of numba, which may change with any version of it. Where something is missing, importing this
module raises `ImportError`, and `jit` and `kernel_cache` do without: the same results, compiled in every process.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import llvmlite.binding as llvm
import numba
from llvmlite.ir import IRBuilder
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import IRLegalization, NativeLowering
from numba.core.types.functions import BaseFunction
from numba.core.untyped_passes import InlineClosureLikes

from .call_type_cache import kept_calls as kept_calls
from .dead_branch_pruning import DecideTestsForNone
from .direct_lowering import DirectLowering
from .flag_comparison import QuickFlags
from .folded_tuples import FoldingBuilder
from .registry_refresh import refresh_after_imports

_METHODS = {
    JITCodeLibrary: (
        "_ensure_finalized", "_finalize_dynamic_globals", "_finalize_final_module", "_get_module_for_linking",
        "_optimize_final_module", "add_ir_module", "enable_object_caching", "serialize_using_object_code",
    ),
    CompileResult: ("_rebuild", "_reduce"),
    Lower: ("_find_singly_assigned_variable", "post_lower", "setup_function"),
    BaseFunction: ("get_call_type", "get_impl_key"),
    IRBuilder: ("extract_value",),
}  # fmt: skip
for _kind, _names in _METHODS.items():
    for _name in _names:
        if not hasattr(_kind, _name):
            raise ImportError(f"numba {numba.__version__} has no {_kind.__name__}.{_name}")

# What stands in front of such code on disk, where numba has the name of its own two formats.
_FORMAT = "intermediate"


class MachineCode(JITCodeLibrary):
    """The library of a function that Python calls with tuples of many arrays.

    Its entry takes the tuples apart, which is so much code that optimizing it takes longer than the function does, for a
    microsecond: it is left as it is.
    """

    def add_ir_module(self, ir_module: Any) -> None:
        """Add a module; the entry from Python is not optimized."""
        for function in ir_module.functions:
            if not function.is_declaration and function.name.startswith("_ZN7cpython"):
                function.attributes.add("noinline")
                function.attributes.add("optnone")
        super().add_ir_module(ir_module)


class IntermediateCode(JITCodeLibrary):
    """The library of a function that is linked into its callers; it has no address."""

    @property
    def codegen(self) -> Any:
        """Numba's code generator, or this itself where it sets an environment: that of a function without an address."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing: the environment is set where the function lies in machine code, with its caller."""

    def _optimize_final_module(self) -> None:
        """Do nothing: the callers do that."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is none."""
        self._ensure_finalized()
        return 0

    def _get_module_for_linking(self) -> Any:
        """Return the module itself, its functions as such that several libraries may have; numba would change a copy."""
        self._ensure_finalized()
        if self._shared_module is None:
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == llvm.Linkage.external:
                    function.linkage = "linkonce_odr"
            self._shared_module = self._final_module
        return self._shared_module

    def serialize_using_object_code(self) -> Any:
        """Return what is kept on disk."""
        self._ensure_finalized()
        return self.name, _FORMAT, self._get_module_for_linking().as_bitcode()

    def load(self, content: bytes) -> None:
        """Take what `serialize_using_object_code` gave."""
        self._final_module = self._shared_module = llvm.parse_bitcode(content)
        self._finalize_final_module()


@register_pass(mutates_CFG=False, analysis_only=False)
class _MakeMachineCode(LoweringPass):
    """Have the pass that follows, which writes LLVM's code, write it into a `MachineCode` where tuples are handed over."""

    _name = "make_machine_code"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> Any:
        """Make the library; return whether the state has changed."""
        if not _has_tuple_of_arrays(state.args):
            return False
        state.library = MachineCode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return True


def _has_tuple_of_arrays(arguments: Any) -> bool:
    return any(_has_array(kind) for kind in arguments if isinstance(kind, types.BaseTuple))


def _has_array(kind: Any) -> bool:
    if isinstance(kind, types.BaseTuple):
        return any(map(_has_array, iter(kind)))  # type: ignore[call-overload]
    return isinstance(kind, types.Array)


@register_pass(mutates_CFG=False, analysis_only=False)
class _MakeIntermediateCode(LoweringPass):
    """Have the pass that follows, which writes LLVM's code, write it into an `IntermediateCode`."""

    _name = "make_intermediate_code"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> Any:
        """Make the library; return that the state has changed."""
        state.library = IntermediateCode(state.targetctx.codegen(), state.func_id.func_qualname)
        return True


class _Compiler(CompilerBase):
    """The compiler of numba, but for what it makes, and for passes that save time.

    Attributes:
        making: the pass that makes the library.
        parts: the modules that say what it does besides this one.
    """

    making: type[LoweringPass]
    parts = tuple(one.__module__ for one in (DecideTestsForNone, QuickFlags, DirectLowering, FoldingBuilder))

    def __init__(
        self, typing_context: Any, context: Any, library: Any, arguments: Any, returned: Any, flags: Any, kinds: Any
    ) -> None:
        flags = QuickFlags(flags)
        if self._counts_no_references(arguments):
            flags.nrt = False
        super().__init__(typing_context, context, library, arguments, returned, flags, kinds)
        own = self.state.targetctx  # a copy for this compilation
        own.refresh = partial(refresh_after_imports, own)

    def _counts_no_references(self, arguments: Any) -> bool:
        """Return whether references to arrays are not counted for such arguments; more than what the flags say."""
        return False

    def define_pipelines(self) -> list[Any]:
        """Return numba's passes with two more, and another one for the last."""
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(DecideTestsForNone, InlineClosureLikes)
        manager.add_pass_after(self.making, IRLegalization)
        manager.passes = [(DirectLowering, text) if one is NativeLowering else (one, text) for one, text in manager.passes]
        manager.finalize()
        return [manager]


class UserEntryCompiler(_Compiler):
    """The compiler of functions of others that Python calls."""

    making = _MakeMachineCode


class EntryCompiler(UserEntryCompiler):
    """The compiler of functions of this package that Python calls: those that take tuples of arrays make none.

    Python holds the arrays of the tuples meanwhile: to count references to each takes as long to compile as the rest.
    """

    def _counts_no_references(self, arguments: Any) -> bool:
        return _has_tuple_of_arrays(arguments)


class IntermediateCompiler(_Compiler):
    """The compiler of functions that other kernels alone call."""

    making = _MakeIntermediateCode


def rebuild(context: Any, library: Any, *parts: Any) -> Any:
    """Return a compiled function from what `CompileResult._reduce` gave for it, of either kind."""
    name, kind, content = library
    if kind != _FORMAT:
        return CompileResult._rebuild(context, library, *parts)
    code = IntermediateCode(context.codegen(), name)
    code.load(content)
    return CompileResult._rebuild(_Context(context, code), library, *parts)._replace(target_context=context)


class _Context:
    """The context of a target that finds a library where numba would make one."""

    def __init__(self, context: Any, library: IntermediateCode) -> None:
        self.typing_context, self.get_executable, self._library = context.typing_context, context.get_executable, library

    def codegen(self) -> Any:
        """Return this."""
        return self

    def unserialize_library(self, content: Any) -> IntermediateCode:
        """Return the library that was found."""
        return self._library
