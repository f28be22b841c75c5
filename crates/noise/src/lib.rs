//! proofmass noise.
