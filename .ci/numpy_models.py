#!/usr/bin/env python3
"""Random models against numpy: mean, u, median and 95 % interval by Monte Carlo; none may be refused.

    numpy_models.py EVALUATE_MODELS [COUNT] [SEED]

EVALUATE_MODELS is the example of that name of crates/uncertainty. The models are valid (every trial of numpy is a
number), a third each with uncertainties of about 10, 30 and 60 % of their inputs, of every kind of distribution, alone,
correlated, drawn together or as rows of samples. Exit code 0: all agree; 1: one does not; 77: numpy is not installed.
"""
import json
import math
import random
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("no numpy (pip install numpy): not compared")
    sys.exit(77)

TRIALS = 100_000
# Standard deviations allowed: of some ten thousand comparisons one in a hundred seeds goes beyond by chance.
ALLOWED = 5.0


def numbers(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def one(rng, draw, value, u):
    """Text of an input with about this value and u, its draws, and its estimate."""
    shapes = [
        "normal", "dof", "rectangular", "triangular", "arcsine", "limits", "t", "trapezoid", "curvilinear", "truncated",
        "one-sided", "exponential", "gamma", "stretched", "lognormal", "beta", "poisson", "discrete", "samples", "readings",
    ]
    kind = rng.choice(shapes)
    n, a = TRIALS, u * math.sqrt(3)
    uniform = lambda low, high: draw.uniform(low, high, n)
    dist = lambda words: f"distribution = {{ {words} }}\n"
    if kind == "normal":
        return f"value = {value}\nu = {u}\n", value + u * draw.standard_normal(n), value
    if kind == "dof":
        nu = rng.randint(5, 40)
        return f"value = {value}\nu = {u}\ndof = {nu}\n", value + u * draw.standard_t(nu, n), value
    if kind == "rectangular":
        return f"value = {value}\nhalf_width = {a}\n", uniform(value - a, value + a), value
    if kind == "triangular":
        x = value + a * (draw.random(n) - draw.random(n))
        return f'value = {value}\nhalf_width = {a}\nshape = "triangular"\n', x, value
    if kind == "arcsine":
        x = value + a * np.sin(uniform(0, 2 * math.pi))
        return f'value = {value}\nhalf_width = {a}\nshape = "arcsine"\n', x, value
    if kind == "limits":  # doubtful ones
        nu = rng.randint(3, 30)
        share = math.sqrt(1.5 / nu)
        x = value + a * uniform(1 - share, 1 + share) * uniform(-1, 1)
        return f"value = {value}\nhalf_width = {a}\ndof = {nu}\n", x, value
    if kind == "t":
        nu = round(rng.uniform(4.5, 30), 2)
        text = f'kind = "student-t", location = {value}, scale = {u}, dof = {nu}'
        return dist(text), value + u * draw.standard_t(nu, n), value
    if kind == "trapezoid":
        beta = round(rng.uniform(0.1, 0.9), 2)
        # The sum of two rectangular quantities.
        x = value + a * (uniform(-1, 1) * (1 + beta) / 2 + uniform(-1, 1) * (1 - beta) / 2)
        return dist(f'kind = "trapezoidal", lower = {value - a}, upper = {value + a}, beta = {beta}'), x, value
    if kind == "curvilinear":
        d = 0.3 * a
        low = uniform(value - a - d, value - a + d)
        x = low + 2 * (value - low) * draw.random(n)
        text = f'kind = "curvilinear-trapezoid", lower = {value - a}, upper = {value + a}, inexactness = {d}'
        return dist(text), x, value
    if kind in ("truncated", "one-sided"):
        low, high = value - 1.2 * u, value + 0.7 * u if kind == "truncated" else math.inf
        x = np.empty(0)
        while len(x) < n:
            more = value + u * draw.standard_normal(2 * n)
            x = np.concatenate([x, more[(more >= low) & (more <= high)]])
        phi = lambda z: math.exp(-z * z / 2) / math.sqrt(2 * math.pi)
        cdf = lambda z: 0.5 * (1 + math.erf(z / math.sqrt(2)))
        top = (phi(0.7), cdf(0.7)) if kind == "truncated" else (0.0, 1.0)
        estimate = value + u * (phi(1.2) - top[0]) / (top[1] - cdf(-1.2))
        text = f'kind = "truncated-normal", mean = {value}, sd = {u}, lower = {low}'
        return dist(text + (f", upper = {high}" if kind == "truncated" else "")), x[:n], estimate
    low = value - u
    if kind == "exponential":
        return dist(f'kind = "exponential", mean = {value}, lower = {low}'), low + draw.exponential(value - low, n), value
    if kind in ("gamma", "stretched"):
        shape = round(rng.uniform(0.5, 8), 2)
        scale = u / math.sqrt(shape)
        x, text = value + draw.gamma(shape, scale, n), f'kind = "gamma", shape = {shape}, scale = {scale}, lower = {value}'
        if kind == "gamma":
            return dist(text), x, value + shape * scale
        nu, middle = rng.randint(6, 40), value + shape * scale
        x = middle + np.sqrt(nu / draw.chisquare(nu, n)) * (x - middle)
        return dist(text) + f"dof = {nu}\n", x, middle
    if kind == "lognormal":
        sigma = min(u / value, 0.6)
        x = value * np.exp(sigma * draw.standard_normal(n))
        return dist(f'kind = "lognormal", median = {value}, sigma = {sigma}'), x, value * math.exp(sigma ** 2 / 2)
    if kind == "beta":
        p, q = round(rng.uniform(0.4, 5), 2), round(rng.uniform(0.4, 5), 2)
        x = value - a + 2 * a * draw.beta(p, q, n)
        text = f'kind = "beta", alpha = {p}, beta = {q}, lower = {value - a}, upper = {value + a}'
        return dist(text), x, value - a + 2 * a * p / (p + q)
    if kind == "poisson":
        mean = round(rng.uniform(1, 60), 2)
        scale = u / math.sqrt(mean)
        x = value + scale * draw.poisson(mean, n)
        return dist(f'kind = "poisson", mean = {mean}, scale = {scale}, lower = {value}'), x, value + scale * mean
    if kind in ("discrete", "samples"):
        values = [value + u * rng.gauss(0, 1) for _ in range(rng.randint(3, 60))]
        weights = [rng.uniform(0.2, 2) if kind == "discrete" else 1.0 for _ in values]
        share = np.array(weights) / sum(weights)
        extra = f", weights = {numbers(weights)}" if kind == "discrete" else ""
        text = f'kind = "{kind}", values = {numbers(values)}{extra}'
        return dist(text), draw.choice(values, n, p=share), float(np.dot(values, share))
    values = [value + u * rng.gauss(0, 1) for _ in range(rng.randint(7, 20))]
    mean, s = float(np.mean(values)), float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return f"observations = {numbers(values)}\n", mean + s * draw.standard_t(len(values) - 1, n), mean


def inputs(rng, draw, share):
    """Text, and columns of draws by name, the estimate last."""
    names = [f"x{i}" for i in range(rng.randint(1, 5))]
    way = rng.choice(["alone", "alone", "alone", "correlated", "together", "rows"]) if len(names) > 1 else "alone"
    values = [round(rng.uniform(0.5, 3.0), 4) for _ in names]
    us = [round(v * share * rng.uniform(0.5, 1.5), 5) for v in values]
    head = lambda name: f'[[input]]\nname = "{name}"\nunit = "1"\n'
    text, columns = "", {}
    if way == "alone":
        for name, v, u in zip(names, values, us):
            statement, x, estimate = one(rng, draw, v, u)
            text += head(name) + statement
            columns[name] = np.append(x, estimate)
        return text, columns
    if way == "rows":
        size = rng.randint(20, 200)
        table = np.array([[v + u * rng.gauss(0, 1) for v, u in zip(values, us)] for _ in range(size)])
        picked = table[draw.integers(0, size, TRIALS)]
        for k, name in enumerate(names):
            text += head(name) + f'together = "chain"\ndistribution = {{ kind = "samples", values = {numbers(table[:, k])} }}\n'
            columns[name] = np.append(picked[:, k], table[:, k].mean())
        return text, columns
    r = round(rng.uniform(-0.9 / (len(names) - 1), 0.9), 3)
    matrix = np.full((len(names), len(names)), r) + (1 - r) * np.eye(len(names))
    z = draw.standard_normal((TRIALS, len(names))) @ np.linalg.cholesky(matrix).T
    nu = rng.randint(5, 30)
    if way == "together":
        z *= np.sqrt(nu / draw.chisquare(nu, TRIALS))[:, None]
    for k, (name, v, u) in enumerate(zip(names, values, us)):
        text += head(name) + f"value = {v}\nu = {u}\n" + (f'dof = {nu}\ntogether = "set"\n' if way == "together" else "")
        columns[name] = np.append(v + u * z[:, k], v)
        for other in names[:k]:
            text += f'[[correlation]]\nbetween = ["{name}", "{other}"]\ncoefficient = {r}\n'
    return text.replace("[[correlation]]", "\n[[correlation]]"), columns


def formula(rng, names, depth):
    """Text, and a function of the columns."""
    if depth == 0 or rng.random() < 0.15:
        if rng.random() < 0.85:
            name = rng.choice(names)
            return name, lambda x: x[name]
        c = round(rng.uniform(0.5, 3.0), 3)
        return repr(c), lambda x: c
    sub = lambda: formula(rng, names, depth - 1)
    kind = rng.random()
    if kind < 0.5:
        (a, f), (b, g) = sub(), sub()
        sign, calc = rng.choice([("+", np.add), ("-", np.subtract), ("*", np.multiply), ("/", np.divide)])
        return f"({a} {sign} {b})", lambda x: calc(f(x), g(x))
    if kind < 0.6:
        a, f = sub()
        n = rng.choice([2, 3, -1, 0.5])
        return f"({a})^({n})", lambda x: np.power(f(x), float(n))
    if kind < 0.8:
        a, f = sub()
        name, calc = rng.choice([
            ("sin", np.sin), ("cos", np.cos), ("atan", np.arctan), ("tanh", np.tanh), ("exp", np.exp), ("sqrt", np.sqrt),
            ("ln", np.log), ("abs", np.abs), ("cbrt", np.cbrt),
        ])
        return f"{name}({a})", lambda x: calc(f(x))
    (a, f), (b, g) = sub(), sub()
    if kind < 0.84:
        return f"min({a}, {b})", lambda x: np.minimum(f(x), g(x))
    if kind < 0.88:
        return f"max({a}, {b})", lambda x: np.maximum(f(x), g(x))
    if kind < 0.92:
        return f"hypot({a}, {b})", lambda x: np.hypot(f(x), g(x))
    if kind < 0.96:
        c, h = sub()
        return f"if({a} < {b}, {c}, {b})", lambda x: np.where(f(x) < g(x), h(x), g(x))

    def angle(x):
        y = np.arctan2(f(x), g(x)) * np.ones(TRIALS + 1)
        turns = (y - y[-1]) / (2 * np.pi)
        # About its value at the estimates; exactly opposite it, as in atan2(a, a), either side is right: such a model is
        # left out.
        return np.where(abs(abs(turns) - 0.5) < 1e-9, np.nan, y - 2 * np.pi * np.round(turns))

    return f"atan2({a}, {b})", angle


def model(rng, draw, share):
    text, columns = inputs(rng, draw, share)
    outputs = []
    with np.errstate(all="ignore"):
        for k in range(rng.randint(1, 2)):
            words, f = formula(rng, sorted(columns), 4)
            text += f'\n[[output]]\nname = "y{k}"\nunit = "1"\nexpression = "{words}"\n'
            outputs.append(f(columns) * np.ones(TRIALS + 1))
    return text, outputs


def differences(got, y):
    """What is farther off than chance allows."""
    y = y[:-1]
    bad = []
    for name, p in (("lower", 0.025), ("median", 0.5), ("upper", 0.975)):
        # Where their value stands among ours: the same for every distribution.
        bound = ALLOWED * math.sqrt(p * (1 - p) * 2 / TRIALS) + 1.0 / TRIALS
        slack = 1e-9 * max(abs(got[name]), float(np.std(y)))
        if np.mean(y < got[name] - slack) > p + bound or np.mean(y <= got[name] + slack) < p - bound:
            bad.append(f"{name}: {got[name]} holds {np.mean(y < got[name])} to {np.mean(y <= got[name])} of numpy's")
    mean, u = float(np.mean(y)), float(np.std(y))
    kurtosis = float(np.mean(((y - mean) / u) ** 4)) if u > 0 else 1.0
    compared = got["u"] is not None and kurtosis < 20
    if compared:
        for name, theirs, error in (
            ("mean", mean, u * math.sqrt(2 / TRIALS)),
            ("u", u, u * math.sqrt(max(kurtosis - 1, 0) / 2 / TRIALS)),
        ):
            if abs(got[name] - theirs) > ALLOWED * error + 1e-9 * max(abs(mean), u):
                bad.append(f"{name}: {got[name]}, numpy {theirs} ± {error:.1e}")
    return bad, compared


def main():
    arguments = sys.argv + [""] * 3
    evaluate, count, seed = arguments[1], int(arguments[2] or 450), int(arguments[3] or 1)
    rng, draw = random.Random(seed), np.random.default_rng(seed)
    wrong = refused = moments = outputs = done = 0
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/model.toml"
        while done < count:
            share = (0.1, 0.3, 0.6)[done % 3]
            text, theirs = model(rng, draw, share)
            if not all(np.isfinite(y).all() and np.abs(y).max() < 1e12 and np.std(y) > 1e-9 for y in theirs):
                continue
            done += 1
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            run = subprocess.run([evaluate, "--trials", str(TRIALS), path], capture_output=True, text=True, check=True)
            got = json.loads(run.stdout)
            bad = [got["error"]] if "error" in got else []
            refused += len(bad)
            for ours, y in zip(got.get("outputs", []), theirs):
                outputs += 1
                if ours["mean"] is None:
                    bad.append("no Monte Carlo result")
                elif ours["invalid"] > 30:  # numpy had none
                    bad.append(f"{ours['invalid']} invalid trials")
                else:
                    more, compared = differences(ours, y)
                    bad += more
                    moments += compared
            if bad:
                wrong += 1
                print(text, *bad, sep="\n")
    print(f"{count} random models against numpy {np.__version__}: {refused} refused, {wrong} differ; "
          f"{outputs} outputs, mean and u of {moments}")
    sys.exit(1 if wrong else 0)


main()
