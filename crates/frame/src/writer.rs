//! The way to the thread that writes, and back.

use crate::event::{Events, RenderError, Summary};
use crate::output::Finished;
use crate::pictures::Pictures;
use reflet_film::Picture;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// The way to the thread that writes, and back.
pub(crate) struct Writer<'e> {
    /// To the thread.
    pub finished: Sender<Finished>,
    /// From it.
    pub written: Receiver<Result<Finished, RenderError>>,
    /// Frames sent and not come back.
    pub under_way: usize,
    /// What was done so far.
    pub summary: Summary,
    /// Who is told.
    pub events: &'e Events<'e>,
}

impl Writer<'_> {
    /// Sends a frame to be written.
    pub fn write(&mut self, frame: Finished) {
        // If the writer has failed, its error is on the way back.
        if self.finished.send(frame).is_ok() {
            self.under_way += 1;
        }
    }

    /// A picture to shade into; waits for one if all are under way.
    pub fn take(&mut self, pictures: &mut Pictures) -> Result<Picture, RenderError> {
        loop {
            if let Some(picture) = pictures.take() {
                return Ok(picture);
            }
            if self.under_way == 0 {
                pictures.forget_last();
                continue;
            }
            match self.written.recv() {
                Ok(frame) => pictures.give_back(self.count(frame?)),
                Err(_) => return Err(RenderError::Other("the writer has stopped".to_owned())),
            }
        }
    }

    /// Takes back what has been written by now.
    pub fn reclaim(&mut self, pictures: &mut Pictures) -> Result<(), RenderError> {
        while let Ok(frame) = self.written.try_recv() {
            pictures.give_back(self.count(frame?));
        }
        Ok(())
    }

    /// Waits until all is written.
    pub fn finish(mut self) -> Result<Summary, RenderError> {
        let (closed, _) = channel();
        drop(std::mem::replace(&mut self.finished, closed));
        while let Ok(frame) = self.written.recv() {
            self.count(frame?);
        }
        Ok(self.summary)
    }

    fn count(&mut self, frame: Finished) -> Arc<Picture> {
        let r = &frame.report;
        self.under_way -= 1;
        self.summary.count(r);
        frame.picture
    }
}
