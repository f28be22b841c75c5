//! Evaluates model files for comparison with other programs: one line of JSON per file.
//!
//! By the law of propagation (`.ci/gtc.py`): values, u, ν and the covariance of the outputs. With `--trials N` by every
//! road, as `proofmass uncertainty` does (`.ci/numpy_models.py`): figures of N trials.

use proofmass_uncertainty::{DegreesOfFreedom, Evaluate, Trials, UncertaintyModel, propagate};
use serde_json::{Value, json};
use std::error::Error;
use std::ops::ControlFlow;

fn finite(nu: DegreesOfFreedom) -> Value {
    if nu.is_infinite() {
        Value::Null
    } else {
        json!(nu.get())
    }
}

fn read(path: &str) -> Result<UncertaintyModel, Box<dyn Error>> {
    Ok(toml::from_str(&std::fs::read_to_string(path)?)?)
}

fn linear(path: &str) -> Result<Value, Box<dyn Error>> {
    let (joint, equations) = read(path)?.prepared()?;
    let linear = propagate(&equations, &joint)?;
    let estimate = linear.estimate();
    let names: Vec<&str> = estimate
        .components()
        .iter()
        .map(|c| c.name.as_str())
        .collect();
    let quantities: Vec<_> = names.iter().filter_map(|name| linear.get(name)).collect();
    Ok(json!({
        "file": path,
        "names": names,
        "value": quantities.iter().map(|q| q.value).collect::<Vec<f64>>(),
        "u": quantities.iter().map(|q| q.standard_uncertainty).collect::<Vec<f64>>(),
        "dof": quantities.iter().map(|q| finite(q.dof)).collect::<Vec<Value>>(),
        "covariance": estimate.covariance().elements(),
    }))
}

fn sampled(path: &str, trials: usize) -> Result<Value, Box<dyn Error>> {
    let options = Evaluate {
        trials: Trials::Fixed(trials),
        ..Evaluate::default()
    };
    let result = read(path)?.evaluate(&options, &mut |_| ControlFlow::Continue(()))?;
    let outputs = result.outputs.iter().map(|output| {
        let trials = output.monte_carlo.as_ref();
        json!({
            "linear": output.linear.is_some(),
            "invalid": trials.map(|t| t.invalid),
            "mean": trials.map(|t| t.mean),
            "u": trials.and_then(|t| t.standard_uncertainty),
            "median": trials.map(|t| t.median),
            "lower": trials.map(|t| t.symmetric.lower),
            "upper": trials.map(|t| t.symmetric.upper),
        })
    });
    Ok(json!({
        "file": path,
        "trials": result.trials,
        "outputs": outputs.collect::<Vec<Value>>(),
    }))
}

fn main() {
    let mut arguments = std::env::args().skip(1).peekable();
    let mut trials = None;
    if arguments.next_if(|a| a == "--trials").is_some() {
        trials = arguments.next().and_then(|n| n.parse().ok());
    }
    for path in arguments {
        let line = match trials {
            None => linear(&path),
            Some(trials) => sampled(&path, trials),
        };
        let line = line.unwrap_or_else(|e| json!({ "file": path, "error": e.to_string() }));
        println!("{line}");
    }
}
