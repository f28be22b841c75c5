//! Values come back from a file as they went in, and a damaged file brings back none.
#![cfg(feature = "serde")]

use proofmass_core::{Gravity, Matrix3, SensorModel};

#[test]
fn law_a_model_comes_back_bit_for_bit() {
    let k = Matrix3([[414.4, 1.3, -0.1], [0.0, 412.0, 2.1], [0.0, 0.0, 414.6]]);
    let model = SensorModel::new(k, [33_123.9, 33_275.2, 1.0 / 3.0]).unwrap();
    let text = serde_json::to_string(&model).unwrap();
    assert_eq!(
        serde_json::from_str::<SensorModel<f64>>(&text).unwrap(),
        model
    );
}

#[test]
fn refuses_a_singular_model_and_gravity_of_another_planet() {
    let singular = r#"{"k":[[1.0,0.0,0.0],[1.0,0.0,0.0],[0.0,0.0,1.0]],"bias":[0.0,0.0,0.0]}"#;
    assert!(serde_json::from_str::<SensorModel<f64>>(singular).is_err());
    let moon = r#"{"value":1.62,"standard_uncertainty":0.0}"#;
    assert!(serde_json::from_str::<Gravity>(moon).is_err());
    let here = Gravity::given(9.8056, 1e-5).unwrap();
    let text = serde_json::to_string(&here).unwrap();
    assert_eq!(serde_json::from_str::<Gravity>(&text).unwrap(), here);
}
