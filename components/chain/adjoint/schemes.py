"""`reverse_tick`: the reverse of `integrators.scheme.one_tick`, registered for the integrators that have one."""

from __future__ import annotations

from ...support.dispatch import dispatched


@dispatched
def reverse_tick(scheme, chain, adjoint, inputs, input_adjoint, tape):
    """Carry the adjoint from the end of a tick to its begin, and add the derivatives by the inputs to `input_adjoint`.

    Args:
        scheme: the integrator.
        chain: a `ChainState` with the constants of the run.
        adjoint: a `ChainState` of the adjoint table.
        inputs: held left and right, shape (2,).
        input_adjoint: likewise.
        tape: the rows that `one_tick` wrote in that tick.
    """
