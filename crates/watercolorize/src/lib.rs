//! A picture becomes a painting.
//!
//! In the order data flows:
//! - [`mod@superpixels`]: pixels gathered into small patches of one color;
//! - [`mod@mattes`]: patches gathered into regions, a matte each;
//! - [`scissors`]: a matte cut out by hand, along the outlines of the picture;
//! - [`c97`]: mattes and an ordered list of pigments become a document, as in Curtis et al. 1997, §6.2.
#![forbid(unsafe_code)]

pub mod superpixels;
pub mod mattes;
pub mod scissors;
pub mod c97;
