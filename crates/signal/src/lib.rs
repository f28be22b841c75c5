//! proofmass signal.
