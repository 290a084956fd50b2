//! AV1 (by rav1e) in IVF: 4:4:4, full range, the matrix of BT.601, as in our YUV4MPEG2.
//!
//! The number of tiles is fixed, so that the bytes do not depend on the number of threads.

use super::{FilmSpec, Shot, y4m};
use crate::transfer::Transfer;
use rav1e::prelude::*;
use std::io::{self, ErrorKind, Write};

pub(super) struct Av1Film<W> {
    sink: W,
    encoder: Context<u8>,
    planes: Vec<u8>,
}

impl<W> std::fmt::Debug for Av1Film<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Av1Film").finish_non_exhaustive()
    }
}

impl<W: Write> Av1Film<W> {
    pub(super) fn new(mut sink: W, spec: &FilmSpec) -> io::Result<Self> {
        let (numerator, denominator) = (spec.fps.numerator(), spec.fps.denominator());
        let config = EncoderConfig {
            width: spec.width as usize,
            height: spec.height as usize,
            time_base: Rational::new(denominator.into(), numerator.into()),
            bit_depth: 8,
            chroma_sampling: ChromaSampling::Cs444,
            pixel_range: PixelRange::Full,
            color_description: Some(ColorDescription {
                color_primaries: ColorPrimaries::BT709,
                transfer_characteristics: match spec.transfer {
                    Transfer::Srgb => TransferCharacteristics::SRGB,
                    Transfer::Linear => TransferCharacteristics::Linear,
                },
                matrix_coefficients: MatrixCoefficients::BT601,
            }),
            quantizer: 60,
            tiles: 4,
            speed_settings: SpeedSettings::from_preset(8),
            ..EncoderConfig::default()
        };
        let encoder = Config::new().with_encoder_config(config).new_context();
        let encoder = encoder.map_err(|error| {
            let message = format!("a film of {} x {} in AV1: {error}", spec.width, spec.height);
            io::Error::new(ErrorKind::InvalidInput, message)
        })?;
        let mut head = b"DKIF\0\0\x20\0AV01".to_vec();
        head.extend_from_slice(&(spec.width as u16).to_le_bytes());
        head.extend_from_slice(&(spec.height as u16).to_le_bytes());
        for number in [numerator, denominator, spec.frames, 0] {
            head.extend_from_slice(&number.to_le_bytes());
        }
        sink.write_all(&head)?;
        Ok(Self { sink, encoder, planes: Vec::new() })
    }

    pub(super) fn push(&mut self, shot: &Shot<'_>) -> io::Result<()> {
        self.planes.resize(shot.frame.len(), 0);
        y4m::planes(shot.frame, &mut self.planes);
        let mut frame = self.encoder.new_frame();
        let planes = self.planes.chunks_exact(shot.frame.len() / 3);
        for (plane, samples) in frame.planes.iter_mut().zip(planes) {
            plane.copy_from_raw_u8(samples, shot.width, 1);
        }
        self.encoder.send_frame(frame).map_err(failed)?;
        self.drain()
    }

    /// Writes what is encoded by now.
    fn drain(&mut self) -> io::Result<()> {
        loop {
            match self.encoder.receive_packet() {
                Ok(packet) => {
                    let mut bytes = (packet.data.len() as u32).to_le_bytes().to_vec();
                    bytes.extend_from_slice(&packet.input_frameno.to_le_bytes());
                    bytes.extend_from_slice(&packet.data);
                    self.sink.write_all(&bytes)?;
                }
                Err(EncoderStatus::Encoded) => {}
                Err(EncoderStatus::NeedMoreData | EncoderStatus::LimitReached) => return Ok(()),
                Err(error) => return Err(failed(error)),
            }
        }
    }

    pub(super) fn finish(mut self) -> io::Result<W> {
        self.encoder.flush();
        self.drain()?;
        Ok(self.sink)
    }
}

fn failed(status: EncoderStatus) -> io::Error {
    io::Error::other(format!("AV1: {status}"))
}
