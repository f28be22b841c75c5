//! Raw signals of an encoder: logic levels, voltages of a resolver.

use super::Reading;
use crate::findings;
use crate::trouble::Trouble;
use proofmass_core::Error;
use proofmass_io::{RecordedColumn, Recording};
use proofmass_motion::{
    Decoded, Excitation, Samples, TimedEdge, demodulated, even_step, indexed, levels, quadrature,
    quadrature_edges, resolver, teeth,
};
use proofmass_uncertainty::Finding;

impl Reading {
    /// Angle of a resolver, of a carrier first freed.
    pub(super) fn resolved(
        &self,
        recording: &Recording,
        columns: &[RecordedColumn],
        clock: &[f64],
        missing: &[&[usize]],
        findings: &mut Vec<Finding>,
    ) -> Result<Samples, Trouble> {
        let place = |e: Error| Trouble::from(e).detail(recording.path.display().to_string());
        let radius = self.radius("a resolver's voltages")?;
        let (sine, cosine) = (&columns[0].data, &columns[1].data);
        if !self.is_modulated() {
            let found = resolver(sine, cosine).map_err(place)?;
            findings.extend(found.findings);
            let value: Vec<f64> = found.angle.iter().map(|a| radius * a).collect();
            let mut missing = missing.to_vec();
            missing.push(&found.lost);
            return Ok(Samples::present(clock, &value, &missing));
        }
        if let Some(k) = missing.iter().copied().flatten().next() {
            return Err(Trouble::data(format!(
                "{}:{}: a voltage of the resolver is missing, and a carrier is demodulated from even samples",
                recording.path.display(),
                recording.line(*k)
            )));
        }
        let excitation = match (self.carrier, columns.get(2)) {
            (_, Some(column)) => Excitation::Voltage(&column.data),
            (Some(carrier), None) => Excitation::Frequency(carrier),
            (None, None) => Excitation::Frequency(f64::NAN),
        };
        let (first, step) = match (clock.first(), even_step(clock)) {
            (Some(first), Some(Ok(step))) => (*first, step),
            (_, Some(Err(k))) => {
                return Err(Trouble::data(format!(
                "{}:{}: the samples of the resolver are not even, so that its carrier cannot be taken out",
                recording.path.display(),
                recording.line(k)
            ))
            .with_hint("cut the recording before the gap, or give --rate where the time stamps are poor"));
            }
            _ => return Ok(Samples::default()),
        };
        let found = demodulated(first, step, sine, cosine, excitation).map_err(|e| {
            place(e).with_hint(
                "--excitation names the column of the exciting voltage, --carrier its frequency; eight samples to a period and more",
            )
        })?;
        let angles = resolver(&found.sine, &found.cosine).map_err(place)?;
        findings.push(findings::resolver_demodulated(
            found.carrier,
            found.block,
            found.time.len(),
        ));
        findings.extend(angles.findings);
        let value: Vec<f64> = angles.angle.iter().map(|a| radius * a).collect();
        Ok(Samples::present(&found.time, &value, &[&angles.lost]))
    }

    /// Counts of logic levels.
    pub(super) fn logic(
        &self,
        recording: &Recording,
        columns: &[RecordedColumn],
        clock: &[f64],
        missing: &[&[usize]],
        findings: &mut Vec<Finding>,
    ) -> Result<Samples, Trouble> {
        let step = self.count_length().map_err(|f| {
            f.detail("counts of the decoded signal: lines times --decoding per turn")
        })?;
        if let Some(k) = missing.iter().copied().flatten().next() {
            return Err(Trouble::data(format!(
                "{}:{}: a logic level is missing",
                recording.path.display(),
                recording.line(*k)
            )));
        }
        if self.teeth.is_some() {
            let count = teeth(&columns[0].data);
            return Ok(Samples {
                time: clock.to_vec(),
                value: count.into_iter().map(|c| step * c as f64).collect(),
            });
        }
        let levels: Vec<Vec<bool>> = columns.iter().map(|c| levels(&c.data)).collect();
        let index = levels.get(2).map(Vec::as_slice);
        let decoded: Decoded = if self.edges {
            let edges: Vec<TimedEdge> = (0..clock.len())
                .map(|k| TimedEdge {
                    time: clock[k],
                    a: levels[0][k],
                    b: levels[1][k],
                    index: index.is_some_and(|z| z[k]),
                })
                .collect();
            quadrature_edges(self.decoding, &edges)
        } else {
            quadrature(self.decoding, &levels[0], &levels[1], index)
        }
        .map_err(|e| Trouble::from(e).detail(recording.path.display().to_string()))?;
        // Of a linear scale nothing is known of the distances of its marks.
        let mut decoded = decoded;
        if let (Some(pulse), Some(_)) = (index, self.counts_per_turn) {
            let found = indexed(
                &decoded.count,
                pulse,
                self.whole_turn()?,
                &decoded.illegal,
                &|k| clock[k],
            )
            .map_err(|e| Trouble::from(e).detail(recording.path.display().to_string()))?;
            decoded.findings.retain(|f| f.code() != "unequal-turns");
            decoded.findings.extend(found.findings);
            decoded.count = found.count;
        }
        let first = decoded.illegal.first().map(|k| recording.line(*k));
        findings.extend(decoded.findings.into_iter().map(|found| match first {
            Some(line) if found.code() == "illegal-transitions" => {
                found.with_evidence(|e| format!("{e}; {}:{line}", recording.path.display()))
            }
            _ => found,
        }));
        let value: Vec<f64> = decoded.count.iter().map(|c| step * *c as f64).collect();
        Ok(Samples {
            time: clock.to_vec(),
            value,
        })
    }
}
