"""The open accelerometer laboratory: numpy in, numpy out, every number with its uncertainty.

>>> import proofmass
>>> result = proofmass.calibrate("examples/hand-held")   # a campaign folder, a recording, an array
>>> result.estimate["scale.x"].value, result.estimate["scale.x"].U
>>> result.write("result")                               # the folder that the command line writes

Every command of the command line is a function with its options as keywords; findings are warnings of the class
`ProofmassWarning`, errors are `ProofmassError`. Notes go to the logger `proofmass`.
"""

import sys
import warnings

from . import records, simulate, test, velocity
from ._batch import Batch, calibrate_batch
from ._calibration import Calibration
from ._campaign import calibrate_campaign, run
from ._commands import (
    apply,
    bias,
    calibrate,
    certificate,
    certificate_check,
    certificate_read,
    certificate_release,
    certificate_template,
    compare,
    convert,
    device_check,
    device_plan,
    explain,
    export,
    filter,
    formats,
    import_,
    init,
    inspect,
    keygen,
    modes,
    noise,
    noise_compare,
    plan,
    render,
    schema,
    uncertainty,
    validate,
    verify,
)
from ._errors import DataError, OutputError, ProofmassError, ProofmassWarning, RequestError
from ._monte_carlo import Sampled, Trials, monte_carlo
from ._result import Covariance, Estimates, Finding, Quantity, Result, read
from ._signals import DeviationCurve, Sine, allan_deviation, fit_sine
from ._uncertain import UncertainArray, UncertainComplex, UncertainNumber, uarray, ucomplex, ufloat

__all__ = [
    "Batch",
    "Calibration",
    "Covariance",
    "DataError",
    "DeviationCurve",
    "Estimates",
    "Finding",
    "OutputError",
    "ProofmassError",
    "ProofmassWarning",
    "Quantity",
    "RequestError",
    "Result",
    "Sampled",
    "Sine",
    "Trials",
    "UncertainArray",
    "UncertainComplex",
    "UncertainNumber",
    "allan_deviation",
    "apply",
    "bias",
    "calibrate",
    "calibrate_batch",
    "calibrate_campaign",
    "certificate",
    "certificate_check",
    "certificate_read",
    "certificate_release",
    "certificate_template",
    "compare",
    "convert",
    "device_check",
    "device_plan",
    "explain",
    "export",
    "filter",
    "fit_sine",
    "formats",
    "import_",
    "init",
    "inspect",
    "keygen",
    "modes",
    "monte_carlo",
    "noise",
    "noise_compare",
    "plan",
    "read",
    "records",
    "render",
    "run",
    "schema",
    "simulate",
    "test",
    "uarray",
    "ucomplex",
    "ufloat",
    "uncertainty",
    "validate",
    "velocity",
    "verify",
]
__version__ = "0.1.0"

if "free-threading" in sys.version:
    warnings.warn(
        "proofmass is not tested on free-threaded builds of Python: results may be checked against those of a usual build",
        RuntimeWarning,
        stacklevel=2,
    )
