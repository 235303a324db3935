#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the constants of Eqs. 7 and 8 of the paper (docs/method.md): every printed ratio is 1. Requires mpmath."""

import random
import mpmath as mp

mp.mp.dps = 60
step = mp.mpf(10) ** -18

def edges(X, first, others):
    return mp.matrix([[X[r, j] - X[r, first] for j in others] for r in range(X.rows)])

def volume(X):
    return mp.det(edges(X, 0, range(1, X.cols))) / mp.factorial(X.rows)

def trace(X):  # Eq. 3, each squared area from a Gram determinant
    total = 0
    for i in range(X.cols):
        face = [j for j in range(X.cols) if j != i]
        A = edges(X, face[0], face[1:])
        total += mp.det(A.T * A) / mp.factorial(X.rows - 1) ** 2
    return total / (X.rows ** 2 * abs(volume(X)))

for d in (2, 3, 4):
    X = mp.matrix(d, d + 1)
    while volume(X) < 0.01:
        for k in range(d * (d + 1)):
            X[k // (d + 1), k % (d + 1)] = mp.mpf(random.uniform(-1, 1))
    v, E = volume(X), edges(X, 0, range(1, d + 1))
    inverse = (E.T) ** -1
    G = mp.matrix(d, d + 1)  # Eq. 18: column i is -a_i n_i / (d v)
    for r in range(d):
        for j in range(d):
            G[r, j + 1] = inverse[r, j]
        G[r, 0] = -mp.fsum(inverse[r, j] for j in range(d))
    an = [-d * v * G[:, i] for i in range(d + 1)]  # a_i n_i
    a2 = [(t.T * t)[0] for t in an]
    L = v * G.T * G  # Eq. 19
    seven = G * (trace(X) * mp.eye(d + 1) - 2 * L)  # Eq. 7 without its constant
    for i in range(d + 1):
        eta = d * d * trace(X)
        eight = (2 * a2[i] / v - eta) * an[i] / v  # Eq. 8 without its constant
        for j in range(d + 1):
            if j != i:
                eight += 2 * (an[i].T * an[j])[0] / v * an[j] / v
        for r in range(d):
            up, down = X.copy(), X.copy()
            up[r, i] += step
            down[r, i] -= step
            slope = (trace(up) - trace(down)) / (2 * step)
            print(d, mp.nstr(slope / seven[r, i], 20), mp.nstr(slope / eight[r] * d ** 3, 20))
