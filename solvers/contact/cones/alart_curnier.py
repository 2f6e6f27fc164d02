"""Alart and Curnier's function of spatial contacts, whose zeros are the solutions, and its generalised Jacobian.

With y = r - rho u, u = W r + q, rho_N = 1 / W_NN and rho_T = 1 / |W_TT| of each contact,

    F_N = r_N - max(y_N, 0),    F_T = r_T - y_T min(1, mu max(y_N, 0) / |y_T|)         (Alart & Curnier 1991)

The Jacobian is I - P (I - rho W), P the derivative of the projection of y: 0 where y_N <= 0; P_NN = 1 otherwise, and
P_TT = I where |y_T| <= mu y_N, else P_TT = k (I - t t^T), P_TN = mu t with t = y_T / |y_T|, k = mu y_N / |y_T|.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["contact_miss", "lengths", "mixed_rows"]


@kernel
def lengths(W_nn: float, W_11: float, W_12: float, W_21: float, W_22: float) -> tuple[float, float]:
    """rho_N and rho_T [kg] of one contact; those of a contact of unit mass where nothing moves it."""
    half, middle = 0.5 * (W_12 + W_21), 0.5 * (W_11 + W_22)
    most = middle + math.sqrt(0.25 * (W_11 - W_22) ** 2 + half * half)
    rho_n = 1.0 / W_nn if W_nn > 0.0 else 1.0
    return rho_n, (1.0 / most if most > 0.0 else rho_n)


@kernel
def contact_miss(
    r_n: float, r_1: float, r_2: float, u_n: float, u_1: float, u_2: float, mu: float, rho_n: float, rho_t: float
) -> tuple[float, float, float]:
    """F of one contact with force r and velocity u."""
    y_n, y_1, y_2 = r_n - rho_n * u_n, r_1 - rho_t * u_1, r_2 - rho_t * u_2
    if y_n <= 0.0:
        return r_n, r_1, r_2
    size, edge = math.sqrt(y_1 * y_1 + y_2 * y_2), mu * y_n
    if size <= edge:
        return rho_n * u_n, rho_t * u_1, rho_t * u_2
    shrink = edge / size
    return rho_n * u_n, r_1 - shrink * y_1, r_2 - shrink * y_2


@kernel
def mixed_rows(
    r_n: float,
    r_1: float,
    r_2: float,
    u_n: float,
    u_1: float,
    u_2: float,
    mu: float,
    rho_n: float,
    rho_t: float,
    keep: FloatArray,
    take: FloatArray,
) -> None:
    """Out: keep = I - P and take = P rho, (9,) each by rows: the Jacobian of one contact is keep + take W."""
    for i in range(9):
        keep[i] = 0.0
        take[i] = 0.0
    y_n, y_1, y_2 = r_n - rho_n * u_n, r_1 - rho_t * u_1, r_2 - rho_t * u_2
    if y_n <= 0.0:
        keep[0], keep[4], keep[8] = 1.0, 1.0, 1.0
        return
    take[0] = rho_n
    size, edge = math.sqrt(y_1 * y_1 + y_2 * y_2), mu * y_n
    if size <= edge:
        take[4], take[8] = rho_t, rho_t
        return
    t_1, t_2, k = y_1 / size, y_2 / size, edge / size
    p_11, p_12, p_22 = k * (1.0 - t_1 * t_1), -k * t_1 * t_2, k * (1.0 - t_2 * t_2)
    keep[3], keep[4], keep[5] = -mu * t_1, 1.0 - p_11, -p_12
    keep[6], keep[7], keep[8] = -mu * t_2, -p_12, 1.0 - p_22
    take[3], take[4], take[5] = mu * t_1 * rho_n, p_11 * rho_t, p_12 * rho_t
    take[6], take[7], take[8] = mu * t_2 * rho_n, p_12 * rho_t, p_22 * rho_t
