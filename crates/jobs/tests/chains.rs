//! What one model states and another reads is what one model of both gives: a few seeds of the program that makes hundreds.

#[path = "../examples/random_chains.rs"]
#[allow(dead_code, reason = "the program has a main of its own")]
mod random_chains;

#[test]
fn law_a_chain_of_models_is_one_model() {
    let tally = random_chains::run(8, 1, 200_000).unwrap();
    assert!(tally.chains >= 6, "{tally:?}");
    assert_eq!(
        (tally.u_beyond, tally.ends_beyond, tally.validated_wrongly),
        (0, 0, 0),
        "{tally:?}"
    );
}
