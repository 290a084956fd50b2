//! Figures with their repeats: kept in a file, and held against those of an earlier run.

use crate::exit::{Exit, Failure};
use reflet_accel::Quality;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::Path;
use std::time::Duration;

/// One thing that was measured several times, at one level on some threads.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Figure {
    /// What took the time.
    pub what: String,
    /// The SIMD level.
    pub isa: String,
    /// How many threads.
    pub threads: usize,
    /// The time of each repetition in nanoseconds, by the CPU clock of all threads.
    pub cpu_ns: Vec<u64>,
    /// Before each of them, the time of the same reference work: how quick the machine was.
    pub reference_ns: Vec<u64>,
}

/// What a run measured, and where: only what is alike in this can be compared.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct About {
    /// The program's version. Others are compared, for that is what one wants to know.
    pub version: String,
    /// The processor's name.
    pub cpu: String,
    /// A frame of a scene, or rays from files.
    pub subject: String,
    /// A hash of all that was read: the packed frame, or the arrays.
    pub inputs: String,
    /// How good a tree was built.
    pub quality: String,
}

impl About {
    /// What this program measures on this machine.
    pub fn new(subject: &str, inputs: String, quality: Quality) -> About {
        About {
            version: env!("CARGO_PKG_VERSION").into(),
            cpu: processor(),
            subject: subject.into(),
            inputs,
            quality: format!("{quality:?}").to_lowercase(),
        }
    }

    /// What differs from what was `before` and makes figures incomparable.
    fn unlike(&self, before: &About) -> Vec<String> {
        let pairs = [
            ("CPU", &self.cpu, &before.cpu),
            ("what is measured", &self.subject, &before.subject),
            ("inputs (their hash)", &self.inputs, &before.inputs),
            ("--quality", &self.quality, &before.quality),
        ];
        let differ = pairs.into_iter().filter(|(_, now, before)| now != before);
        differ.map(|(name, now, before)| format!("{name}: {before} before, {now} now")).collect()
    }
}

/// The processor's name as the system tells it; its architecture where it does not.
fn processor() -> String {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let value = |key: &str| {
        let mut lines = told.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(name, _)| name.trim() == key).map(|(_, value)| value.trim().to_owned())
    };
    let name = ["model name", "Model", "CPU part"].into_iter().find_map(value);
    name.unwrap_or_else(|| std::env::consts::ARCH.into())
}

/// What `--save` keeps.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Record {
    /// Of what.
    pub about: About,
    /// The figures.
    pub figures: Vec<Figure>,
}

impl Record {
    /// Holds what is about to be measured against what this holds.
    ///
    /// # Errors
    /// They are not alike; the message names what differs.
    pub fn fits(&self, path: &Path, about: &About, ways: &[(&str, usize)]) -> Result<(), Failure> {
        let mut unlike = about.unlike(&self.about);
        let measured = |f: &Figure| ways.contains(&(f.isa.as_str(), f.threads));
        if !self.figures.iter().any(measured) {
            let name = |isa: &str, threads: usize| format!("{isa} on {threads}");
            let mut before: Vec<_> = self.figures.iter().map(|f| name(&f.isa, f.threads)).collect();
            before.dedup();
            let now: Vec<_> = ways.iter().map(|(isa, threads)| name(isa, *threads)).collect();
            unlike.push(format!(
                "--isa and --threads: {} before, {} now",
                before.join(", "),
                now.join(", ")
            ));
        }
        if unlike.is_empty() {
            return Ok(());
        }
        Err(Failure::new(
            Exit::Input,
            format!(
                "--against {}: only like is compared with like, and these differ:\n  {}",
                path.display(),
                unlike.join("\n  ")
            ),
        ))
    }
}

/// Two measurements of one thing.
#[derive(Debug, Serialize, PartialEq)]
pub struct Comparison {
    /// What took the time.
    pub what: String,
    /// The SIMD level.
    pub isa: String,
    /// How many threads.
    pub threads: usize,
    /// The median of before.
    pub before_ns: u64,
    /// The median of now.
    pub now_ns: u64,
    /// Now in terms of before.
    pub ratio: f64,
    /// The same of the reference work: above 1 if the machine is slower now.
    pub reference_ratio: f64,
    /// Whether they differ.
    pub verdict: Verdict,
}

/// Whether two measurements differ.
#[derive(Clone, Copy, Debug, Serialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// By less than the measurements themselves vary.
    WithinNoise,
    /// Now takes less time.
    Faster,
    /// Now takes more time.
    Slower,
    /// There are fewer than three repetitions on one side, so nobody knows how much they vary.
    Unknown,
}

/// The fewest repetitions that tell something of their noise.
const FEW: usize = 3;

/// Two runs differ by as much as this for causes that no repetition within one run shows: where
/// the system puts memory and threads, and what else the machine does.
const DRIFT: f64 = 0.05;

impl Figure {
    /// A figure.
    pub fn new(
        what: &str,
        (isa, threads): (&str, usize),
        cpu: &[Duration],
        reference: &[Duration],
    ) -> Figure {
        let ns = |times: &[Duration]| times.iter().map(|t| t.as_nanos() as u64).collect();
        let (cpu_ns, reference_ns) = (ns(cpu), ns(reference));
        Figure { what: what.into(), isa: isa.into(), threads, cpu_ns, reference_ns }
    }

    fn is_of_same(&self, other: &Figure) -> bool {
        (&self.what, &self.isa, self.threads) == (&other.what, &other.isa, other.threads)
    }

    /// Whether this differs from what was `before`: the intervals of the repetitions lie apart, by
    /// more than two runs of one program drift, and by more than the machine itself may have become
    /// slower or quicker.
    fn verdict(&self, before: &Figure) -> Verdict {
        let ((least, most), (old_least, old_most)) =
            (interval(&self.cpu_ns), interval(&before.cpu_ns));
        let (now, then) = (interval(&self.reference_ns), interval(&before.reference_ns));
        let at_most = |now: f64, then: f64| (now / then.max(1.0)).max(1.0) * (1.0 + DRIFT);
        if self.cpu_ns.len().min(before.cpu_ns.len()) < FEW {
            Verdict::Unknown
        } else if least > old_most * at_most(now.1, then.0) {
            Verdict::Slower
        } else if most * at_most(then.1, now.0) < old_least {
            Verdict::Faster
        } else {
            Verdict::WithinNoise
        }
    }
}

fn median(times: &[u64]) -> u64 {
    let mut times = times.to_vec();
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// The least and the greatest.
fn interval(times: &[u64]) -> (f64, f64) {
    let least = times.iter().min().copied().unwrap_or_default();
    (least as f64, times.iter().max().copied().unwrap_or_default() as f64)
}

/// Holds each figure against the one of the same thing before, if there is one.
pub fn compare(now: &[Figure], before: &[Figure]) -> Vec<Comparison> {
    let pairs = now.iter().filter_map(|n| Some((n, before.iter().find(|b| b.is_of_same(n))?)));
    let ratio = |now: &[u64], before: &[u64]| median(now) as f64 / median(before).max(1) as f64;
    let compare = |(now, before): (&Figure, &Figure)| Comparison {
        what: now.what.clone(),
        isa: now.isa.clone(),
        threads: now.threads,
        before_ns: median(&before.cpu_ns),
        now_ns: median(&now.cpu_ns),
        ratio: ratio(&now.cpu_ns, &before.cpu_ns),
        reference_ratio: ratio(&now.reference_ns, &before.reference_ns),
        verdict: now.verdict(before),
    };
    pairs.map(compare).collect()
}

/// A table for people.
pub fn table(comparisons: &[Comparison]) -> String {
    let mut text = String::from(
        "\nagainst before   level    threads    before ms       now ms    ratio   machine   beyond noise\n",
    );
    for c in comparisons {
        let (before, now) = (c.before_ns as f64 * 1e-6, c.now_ns as f64 * 1e-6);
        let verdict = match c.verdict {
            Verdict::WithinNoise => "no",
            Verdict::Faster => "yes, faster",
            Verdict::Slower => "yes, slower",
            Verdict::Unknown => "not known: fewer than 3 repetitions",
        };
        let _ = writeln!(
            text,
            "{:<16} {:<8} {:>7} {before:>12.3} {now:>12.3} {:>8.3} {:>9.3}   {verdict}",
            c.what, c.isa, c.threads, c.ratio, c.reference_ratio
        );
    }
    if comparisons.is_empty() {
        text += "nothing that was measured now was measured before\n";
    }
    text
}

/// Reads what an earlier run kept.
///
/// # Errors
/// An input's.
pub fn read(path: &Path) -> Result<Record, Failure> {
    let fault = |what: String| Failure::new(Exit::Input, format!("{}: {what}", path.display()));
    let text = std::fs::read(path).map_err(|e| fault(e.to_string()))?;
    serde_json::from_slice(&text).map_err(|e| fault(format!("no figures of --save: {e}")))
}

/// Writes figures and what they are of.
///
/// # Errors
/// An output's.
pub fn write(path: &Path, record: &Record) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(record).expect("numbers and names") + "\n";
    super::put(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(cpu_ns: &[u64]) -> Figure {
        let (cpu_ns, reference_ns) = (cpu_ns.to_vec(), vec![500; cpu_ns.len()]);
        Figure { what: "mirror".into(), isa: "avx2".into(), threads: 1, cpu_ns, reference_ns }
    }

    #[test]
    fn only_what_lies_apart_exceeds_the_noise() {
        let before = figure(&[1000, 1040, 1010, 1020, 990]);
        for (now, verdict) in [
            (&[1000, 1040, 1010, 1020, 990][..], Verdict::WithinNoise),
            (&[1030, 1060, 1100, 1020, 1050], Verdict::WithinNoise),
            // Apart, but by no more than runs drift.
            (&[1050, 1080, 1060], Verdict::WithinNoise),
            (&[1100, 1120, 1130], Verdict::Slower),
            (&[900, 910, 920], Verdict::Faster),
            // One that overlaps is enough for a doubt.
            (&[1500, 1500, 1030, 1500], Verdict::WithinNoise),
            (&[2000, 2000], Verdict::Unknown),
            (&[], Verdict::Unknown),
        ] {
            assert_eq!(figure(now).verdict(&before), verdict, "{now:?}");
        }
    }

    #[test]
    fn what_the_machine_itself_may_explain_is_noise() {
        let before = figure(&[1000, 1040, 1010]);
        let mut now = figure(&[1400, 1410, 1450]);
        assert_eq!(now.verdict(&before), Verdict::Slower);
        now.reference_ns = vec![600, 690, 700];
        assert_eq!(now.verdict(&before), Verdict::WithinNoise);
        assert_eq!(before.verdict(&now), Verdict::WithinNoise);
        // A machine that is quicker now explains nothing of a longer time.
        now.reference_ns = vec![300, 310, 320];
        assert_eq!(now.verdict(&before), Verdict::Slower);
    }

    #[test]
    fn like_is_compared_with_like() {
        let before = [figure(&[1000, 1000, 1000])];
        let mut other = figure(&[500, 500, 500]);
        other.threads = 2;
        let now = [other, figure(&[490, 500, 510])];
        let compared = compare(&now, &before);
        assert_eq!(compared.len(), 1);
        assert_eq!((compared[0].ratio, compared[0].verdict), (0.5, Verdict::Faster));
        assert!(table(&compared).contains("yes, faster"));
        assert!(table(&[]).contains("nothing"));
    }
}
