//! Every finding of the odometry room, declared once.

use proofmass_uncertainty::findings;

findings! {
    /// What a comparison of wheels may find.
    pub CATALOGUE;

    /// A wheel spins or locks: its speed is not that of the vehicle.
    wheel_slip(wheels: &str, from: f64, to: f64, change: f64, sense: &str, window: f64, deviations: f64, others: &str) =
        "wheel-slip", [Warning],
        what "the speed of a wheel is not consistent with the motion of the vehicle",
        evidence "{wheels}: {from:.3} s to {to:.3} s, {change:.4} {sense} within {window:.0} ms ({deviations:.1} standard deviations of the quiet part){others}",
        advice "the mean of the wheels is not valid there: leave out the wheel or that part; a wrong sign, unit or track shows in every curve";

}
