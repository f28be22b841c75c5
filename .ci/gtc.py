#!/usr/bin/env python3
"""Random models against GTC: value, u, degrees of freedom and covariance by the law of propagation.

    gtc.py EVALUATE_MODELS [COUNT] [SEED]

EVALUATE_MODELS is the example of that name of crates/uncertainty. Exit code 0: every figure agrees; 1: one does not;
77: GTC is not installed.
"""
import json
import math
import random
import subprocess
import sys
import tempfile

try:
    import GTC
except ImportError:
    print("no GTC (pip install GTC): not compared")
    sys.exit(77)

UNARY = {
    "sin": GTC.sin, "cos": GTC.cos, "atan": GTC.atan, "tanh": GTC.tanh, "exp": GTC.exp,
    "sqrt": GTC.sqrt, "ln": GTC.log,
}


def formula(rng, names, depth):
    """Text for the model file, and a function of the names."""
    if depth == 0 or rng.random() < 0.15:
        if rng.random() < 0.8:
            name = rng.choice(names)
            return name, lambda x: x[name]
        c = round(rng.uniform(0.5, 3.0), 3)
        return repr(c), lambda x: c
    kind = rng.random()
    if kind < 0.6:
        (a, f), (b, g) = (formula(rng, names, depth - 1) for _ in range(2))
        op = rng.choice("+-*/")
        calc = {
            "+": lambda x: f(x) + g(x), "-": lambda x: f(x) - g(x),
            "*": lambda x: f(x) * g(x), "/": lambda x: f(x) / g(x),
        }[op]
        return f"({a} {op} {b})", calc
    a, f = formula(rng, names, depth - 1)
    if kind < 0.7:
        n = rng.choice([2, 3, -1])
        return f"({a})^{n}", lambda x: f(x) ** n
    name = rng.choice(sorted(UNARY))
    return f"{name}({a})", lambda x: UNARY[name](f(x)) if hasattr(f(x), "x") else value(name, f(x))


def value(name, x):
    return getattr(math, {"ln": "log"}.get(name, name))(x)


def real_model(rng, count):
    """Independent inputs with degrees of freedom, a correlated normal set, or an ensemble with one ν."""
    names = [f"x{i}" for i in range(rng.randint(1, 5))]
    way = rng.choice(["independent", "correlated", "ensemble"]) if len(names) > 1 else "independent"
    text, x = "", {}
    values = [round(rng.uniform(0.5, 3.0), 4) for _ in names]
    us = [round(v * rng.uniform(0.001, 0.3), 5) for v in values]
    nu = rng.randint(3, 30)
    for name, v, u in zip(names, values, us):
        text += f'[[input]]\nname = "{name}"\nunit = "1"\nvalue = {v}\n'
        if way == "independent":
            shape = rng.choice(["normal", "dof", "rectangular", "triangular", "arcsine"])
            if shape == "normal":
                text += f"u = {u}\n"
                x[name] = GTC.ureal(v, u)
            elif shape == "dof":
                text += f"u = {u}\ndof = {nu}\n"
                x[name] = GTC.ureal(v, u, nu)
            else:
                text += f'half_width = {u}\nshape = "{shape}"\n'
                root = {"rectangular": 3, "triangular": 6, "arcsine": 2}[shape]
                x[name] = GTC.ureal(v, u / math.sqrt(root))
        else:
            text += f"u = {u}\n" + (f'dof = {nu}\ntogether = "set"\n' if way == "ensemble" else "")
    if way == "ensemble":
        x = dict(zip(names, GTC.multiple_ureal(values, us, nu)))
    elif way == "correlated":
        x = {n: GTC.ureal(v, u, independent=False) for n, v, u in zip(names, values, us)}
    if way != "independent":
        r = round(rng.uniform(-0.9 / (len(names) - 1), 0.9), 3)
        for i, a in enumerate(names):
            for b in names[:i]:
                GTC.set_correlation(r, x[a], x[b])
                text += f'[[correlation]]\nbetween = ["{a}", "{b}"]\ncoefficient = {r}\n'
    outputs = []
    for k in range(rng.randint(1, 3)):
        words, f = formula(rng, names, 5)
        text += f'[[output]]\nname = "y{k}"\nunit = "1"\nexpression = "{words}"\n'
        outputs.append(f(x))
    return text, outputs


def complex_model(rng, count):
    """Rational and transcendent functions of complex quantities, with correlated parts."""
    text, z = "", []
    for k in range(2):
        v = complex(round(rng.uniform(0.3, 2.0), 3), round(rng.uniform(-2.0, 2.0), 3))
        a, b = round(rng.uniform(0.001, 0.2), 4), round(rng.uniform(0.001, 0.2), 4)
        r = round(rng.uniform(-0.9, 0.9), 3)
        for part, value, u in (("re", v.real, a), ("im", v.imag, b)):
            text += f'[[input]]\nname = "{part}{k}"\nunit = "1"\nvalue = {value}\nu = {u}\n'
        text += f'[[correlation]]\nbetween = ["re{k}", "im{k}"]\ncoefficient = {r}\n'
        text += f'[[intermediate]]\nname = "z{k}"\nexpression = "complex(re{k}, im{k})"\n'
        z.append(GTC.ucomplex(v, (a * a, r * a * b, r * a * b, b * b)))
    p, q = z
    choices = [
        ("z0 * z1 / (z0 + z1 + 2)", lambda: p * q / (p + q + 2)),
        ("exp(z0 / 2) - 1 / z1", lambda: GTC.exp(p / 2) - 1 / q),
        ("sqrt(z0) * ln(z1)", lambda: GTC.sqrt(p) * GTC.log(q)),
        ("z0^3 + sin(z1)", lambda: p ** 3 + GTC.sin(q)),
        ("tanh(z0) + cos(z1 * (1 + 2j))", lambda: GTC.tanh(p) + GTC.cos(q * (1 + 2j))),
    ]
    words, f = rng.choice(choices)
    y = f()
    # A complex output first, its modulus and phase by themselves.
    text += f'[[output]]\nname = "y"\nunit = "1"\nexpression = "{words}"\n'
    text += '[[output]]\nname = "modulus"\nunit = "1"\nexpression = "abs(y)"\n'
    text += '[[output]]\nname = "phase"\nunit = "1"\nexpression = "arg(y)"\n'
    return text, [y.real, y.imag, GTC.magnitude(y), GTC.phase(y)]


def sound(y):
    numbers = [y.x, y.u] if hasattr(y, "x") else []
    return bool(numbers) and all(math.isfinite(v) and abs(v) < 1e8 for v in numbers) and y.u > 1e-7 * abs(y.x) + 1e-12


def main():
    evaluate, count, seed = sys.argv[1], int((sys.argv + ["", "", ""])[2] or 700), int((sys.argv + ["", "", "", ""])[3] or 1)
    rng = random.Random(seed)
    expected, files = {}, []
    with tempfile.TemporaryDirectory() as folder:
        while len(files) < count:
            try:
                text, outputs = (complex_model if rng.random() < 0.2 else real_model)(rng, len(files))
                if not all(sound(y) for y in outputs):
                    continue
            except (ValueError, ZeroDivisionError, OverflowError, TypeError, AttributeError):
                continue
            path = f"{folder}/{len(files)}.toml"
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            files.append(path)
            expected[path] = outputs, text
        run = subprocess.run([evaluate, *files], capture_output=True, text=True, check=True)
    worst, wrong, degrees = {"value": 0.0, "u": 0.0, "dof": 0.0, "covariance": 0.0}, 0, 0
    for line in run.stdout.splitlines():
        got = json.loads(line)
        outputs, text = expected[got["file"]]
        bad = []
        if "error" in got:
            bad.append(got["error"])
        else:
            for i, y in enumerate(outputs):
                checks = [("value", got["value"][i], y.x, max(abs(y.x), y.u)), ("u", got["u"][i], y.u, y.u)]
                # What GTC has no figure for (complex quantities with finite ν) is not compared.
                if got["dof"][i] is not None and math.isfinite(y.df):
                    checks.append(("dof", got["dof"][i], y.df, y.df))
                    degrees += 1
                elif (got["dof"][i] is None) != (not math.isfinite(y.df)) and not math.isnan(y.df):
                    # Beyond 10⁶ it makes no difference.
                    if min(got["dof"][i] or math.inf, y.df) < 1e6:
                        bad.append(f"dof of y{i}: {got['dof'][i]} {y.df}")
                for j, other in enumerate(outputs[:i]):
                    c = GTC.get_covariance(y, other)
                    checks.append(("covariance", got["covariance"][i * len(outputs) + j], c, y.u * other.u))
                for what, ours, theirs, scale in checks:
                    off = abs(ours - theirs) / scale
                    worst[what] = max(worst[what], off)
                    if not off < 1e-6:
                        bad.append(f"{what} of y{i}: {ours} {theirs}")
        if bad:
            wrong += 1
            print(text, *bad, sep="\n")
    print(f"{count} random models against GTC {GTC.version}: {wrong} differ; "
          f"{degrees} finite ν; largest relative differences {worst}")
    sys.exit(1 if wrong or len(run.stdout.splitlines()) != count else 0)


main()
