//! Fixtures of a campaign: resonances among its frequencies are told before anything is glued.

use super::{FixtureModes, ModesOutcome};
use crate::campaign::CampaignFile;
use crate::findings;
use crate::outcome::Outcome;
use crate::stored_result::read_section;
use proofmass_io::{Error, ErrorKind, LARGEST_DOCUMENT, Result};
use proofmass_uncertainty::Finding;

/// Inclinations that are the same wedge, rad.
const SAME: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// Results of `modes` that a campaign names.
///
/// # Errors
/// A missing file, or one that is no result of `modes`.
pub fn read_fixtures(source: &CampaignFile, names: &[String]) -> Result<Vec<FixtureModes>> {
    names
        .iter()
        .map(|name| {
            let (bytes, _) = source.source(name)?.into_bytes(LARGEST_DOCUMENT)?;
            let read = read_section(&bytes, ModesOutcome::KIND, FixtureModes::SECTION);
            let (fixture, _) = read.map_err(|trouble| {
                Error::new(ErrorKind::Configuration, trouble.to_string())
                    .at(&source.resolve(name))
                    .with_hint("`fixtures` lists result.json files of `proofmass modes`")
            })?;
            Ok(fixture)
        })
        .collect()
}

/// What fixtures say about the points (inclination in rad, frequency in Hz) of a campaign or a plan.
///
/// A decision where the model puts a resonance that matters within two standard uncertainties, or half its width, of a frequency, and
/// where the spurious motion at a frequency exceeds the share the fixture was asked for.
pub fn fixture_findings(fixtures: &[FixtureModes], points: &[(f64, f64)]) -> Vec<Finding> {
    let mut findings = vec![];
    for fixture in fixtures {
        let degrees = fixture.inclination.to_degrees();
        let mut used: Vec<f64> = points
            .iter()
            .filter(|p| (p.0.abs() - fixture.inclination).abs() < SAME)
            .map(|p| p.1)
            .collect();
        used.sort_by(f64::total_cmp);
        used.dedup();
        let Some(&highest) = used.last() else {
            continue;
        };
        for [f, u, weight] in &fixture.resonances {
            let (f, u, weight) = (*f, *u, *weight);
            if weight < fixture.weight {
                continue;
            }
            let near = 2.0 * u + fixture.damping_ratio * f;
            let hit: Vec<String> = used
                .iter()
                .filter(|x| (*x - f).abs() <= near)
                .map(|x| format!("{x} Hz"))
                .collect();
            if !hit.is_empty() {
                findings.push(findings::fixture_resonance(
                    degrees,
                    f,
                    u,
                    1e2 * weight,
                    &hit.join(", "),
                ));
            }
        }
        if let Some(usable) = fixture.usable.filter(|usable| *usable < highest) {
            let above = used.iter().filter(|f| **f > usable).count();
            findings.push(findings::fixture_beyond_its_range(
                degrees,
                usable,
                1e2 * fixture.share,
                above,
                used.len(),
                highest,
            ));
        }
    }
    findings
}
