"""Return mapping: the stress of a pair back to its limiting line, which all inelastic responses share.

With the equivalent stress s above the limit s_l = onset + H q, q the inelastic strain so far, the deviator of the pair's stress
is multiplied by M = s_new / s, s_new = s_l + H dq, dq = (s - s_l) / (g (3 G + H)) (Wilkins 1964). Of 1 - M the part beta lowers
the stiffness g, g -> M_d g with M_d = 1 - beta (1 - M); the rest, M_p = M / M_d, is flow:

    eps_p -> eps - M_p (eps - eps_p) - (1 - M_p) theta / 3,        gamma_p -> gamma - M_p (gamma - gamma_p).
"""

from __future__ import annotations

from ...support.jit import internal_inlined

# What is left at least of the shear modulus of a pair: that of one that is worn out, which then stays as it is. The stress that
# decides is of both automata, and their other pairs may hold it above the limit for ever.
WORN_OUT = 1e-6


@internal_inlined
def respond(equivalent, eps, gamma, dilation, eps_p, gamma_p, stiffness, inelastic, shear, onset, hardening, degradation):
    """Return the history of a pair after a step: eps_p, gamma_p, stiffness g, inelastic strain q.

    Args:
        equivalent: stress of the pair with the history as it is [Pa].
        eps: strain along the pair.
        gamma: shear angle.
        dilation: mean volumetric strain of both automata.
        eps_p: plastic strain along the pair.
        gamma_p: plastic shear angle.
        stiffness: what is left of the shear modulus, from 1 down.
        inelastic: inelastic strain q.
        shear: G [Pa].
        onset: see `Response.constants` [Pa].
        hardening: H [Pa].
        degradation: beta.
    """
    limit = onset + hardening * inelastic
    if not equivalent > limit or stiffness <= WORN_OUT:
        return eps_p, gamma_p, stiffness, inelastic
    more = (equivalent - limit) / (stiffness * (3.0 * shear + hardening))
    ratio = (limit + hardening * more) / equivalent
    weaker = 1.0 - degradation * (1.0 - ratio)
    flow = ratio / weaker
    return (
        eps - flow * (eps - eps_p) - (1.0 - flow) * dilation / 3.0,
        gamma - flow * (gamma - gamma_p),
        max(weaker * stiffness, WORN_OUT),
        inelastic + more,
    )
