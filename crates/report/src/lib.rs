//! proofmass report.
