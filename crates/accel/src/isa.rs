//! Which instructions are used. All give the same bits.

pub use fearless_simd::Level;
use std::str::FromStr;

/// A choice of SIMD instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Isa {
    /// The best that this machine has.
    #[default]
    Auto,
    /// One value at a time.
    Scalar,
    /// x86 SSE2.
    Sse2,
    /// x86 SSE4.2.
    Sse42,
    /// x86 AVX2.
    Avx2,
    /// x86 AVX-512 as of Ice Lake.
    Avx512,
    /// 64-bit ARM NEON.
    Neon,
}

/// Why a choice of instructions cannot be had.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IsaError {
    /// No such name.
    Unknown(String),
    /// This machine does not have them.
    Unavailable(Isa),
}

impl std::fmt::Display for IsaError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            IsaError::Unknown(name) => {
                write!(f, "unknown instruction set `{name}`; there are")?;
                for isa in Isa::ALL {
                    write!(f, " {}", isa.name())?;
                }
                Ok(())
            }
            IsaError::Unavailable(isa) => {
                write!(f, "this machine has no {}; it has", isa.name())?;
                for isa in Isa::available() {
                    write!(f, " {}", isa.name())?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for IsaError {}

impl FromStr for Isa {
    type Err = IsaError;

    fn from_str(name: &str) -> Result<Isa, IsaError> {
        Isa::ALL
            .into_iter()
            .find(|isa| isa.name() == name)
            .ok_or_else(|| IsaError::Unknown(name.to_owned()))
    }
}

impl Isa {
    /// All choices.
    pub const ALL: [Isa; 7] =
        [Isa::Auto, Isa::Scalar, Isa::Sse2, Isa::Sse42, Isa::Avx2, Isa::Avx512, Isa::Neon];

    /// The name that the command line uses.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Auto => "auto",
            Isa::Scalar => "scalar",
            Isa::Sse2 => "sse2",
            Isa::Sse42 => "sse4.2",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
            Isa::Neon => "neon",
        }
    }

    /// The choices that this machine can run, `auto` apart.
    pub fn available() -> impl Iterator<Item = Isa> {
        Isa::ALL.into_iter().skip(1).filter(|isa| isa.level().is_ok())
    }

    /// What `auto` stands for here; any other choice is itself.
    pub fn resolved(self) -> Isa {
        match self {
            Isa::Auto => [Isa::Avx512, Isa::Avx2, Isa::Sse42, Isa::Sse2, Isa::Neon]
                .into_iter()
                .find(|isa| isa.level().is_ok())
                .unwrap_or(Isa::Scalar),
            isa => isa,
        }
    }

    /// The token that the kernels are dispatched by.
    pub fn level(self) -> Result<Level, IsaError> {
        let best = Level::new();
        let level = match self {
            Isa::Auto => Some(best),
            Isa::Scalar => Some(Level::fallback()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Isa::Sse2 => best.as_sse2().map(Level::Sse2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Isa::Sse42 => best.as_sse4_2().map(Level::Sse4_2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Isa::Avx2 => best.as_avx2().map(Level::Avx2),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Isa::Avx512 => best.as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Isa::Neon => best.as_neon().map(Level::Neon),
            #[allow(unreachable_patterns)]
            _ => None,
        };
        level.ok_or(IsaError::Unavailable(self))
    }
}
