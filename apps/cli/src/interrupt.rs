//! Ctrl-C and a polite kill: the work ends at the next chance, cleanly; a second one ends it at once.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::failure::{Failure, Kind, plain};

/// Whether a signal has come, and which.
#[derive(Clone, Debug)]
pub struct Interrupt {
    came: Arc<AtomicBool>,
    signal: Arc<AtomicUsize>,
}

impl Interrupt {
    /// Listens from now on.
    ///
    /// # Errors
    /// The system refuses.
    pub fn listen() -> Result<Self, Failure> {
        let this = Self { came: Arc::default(), signal: Arc::default() };
        this.register().map_err(|error| Failure::failed(format!("cannot listen: {}", plain(&error))))?;
        Ok(this)
    }

    fn register(&self) -> io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // First of all: it finds the flag set at the second signal only, and then the signal kills as usual.
            flag::register_conditional_default(signal, Arc::clone(&self.came))?;
            flag::register_usize(signal, Arc::clone(&self.signal), signal.unsigned_abs() as usize)?;
            flag::register(signal, Arc::clone(&self.came))?;
        }
        Ok(())
    }

    /// Set once a signal has come.
    pub fn flag(&self) -> &AtomicBool {
        &self.came
    }

    /// Ends the work if a signal has come.
    ///
    /// # Errors
    /// One has.
    pub fn check(&self) -> Result<(), Failure> {
        if self.came.load(Ordering::SeqCst) { Err(self.failure()) } else { Ok(()) }
    }

    /// The failure that ends the work.
    pub fn failure(&self) -> Failure {
        let signal = u8::try_from(self.signal.load(Ordering::SeqCst)).unwrap_or(SIGINT as u8);
        Failure::new(Kind::Interrupted(signal), "interrupted").hint("what was not finished is not written")
    }
}
