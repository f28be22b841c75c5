//! Evaluates model files by the law of propagation, for comparison with other programs (`.ci/gtc.py`): one line of JSON
//! per file, with values, u, ν and the covariance of the outputs.

use proofmass_uncertainty::{DegreesOfFreedom, UncertaintyModel, propagate};
use serde_json::{Value, json};
use std::error::Error;

fn finite(nu: DegreesOfFreedom) -> Value {
    if nu.is_infinite() {
        Value::Null
    } else {
        json!(nu.get())
    }
}

fn evaluate(path: &str) -> Result<Value, Box<dyn Error>> {
    let model: UncertaintyModel = toml::from_str(&std::fs::read_to_string(path)?)?;
    let (joint, equations) = model.prepared()?;
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

fn main() {
    for path in std::env::args().skip(1) {
        let line =
            evaluate(&path).unwrap_or_else(|e| json!({ "file": path, "error": e.to_string() }));
        println!("{line}");
    }
}
