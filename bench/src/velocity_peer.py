"""Prints the seconds of one Kalman step of filterpy, and the velocity it ends with."""
import time

import numpy as np
from filterpy.kalman import KalmanFilter

T, q, r = 1e-3, 4e-4, 7e-8
f = KalmanFilter(dim_x=2, dim_z=1, dim_u=1)
f.x = np.zeros((2, 1))
f.P = np.eye(2)
f.F = np.array([[1.0, T], [0.0, 1.0]])
f.H = np.array([[1.0, 0.0]])
f.B = np.array([[0.5 * T * T], [T]])
f.Q = q * np.array([[T**4 / 4, T**3 / 2], [T**3 / 2, T**2]])
f.R = np.array([[r]])
n = 20000
t = T * np.arange(n)
x, a = 0.06 * np.sin(25 * t), -37.5 * np.sin(25 * t)
best = float("inf")
for _ in range(3):
    f.x[:] = 0
    f.P = np.eye(2)
    start = time.perf_counter()
    for k in range(1, n):
        f.predict(u=a[k - 1])
        f.update(x[k])
    best = min(best, time.perf_counter() - start)
print(best / (n - 1), repr(float(f.x[1, 0])))
