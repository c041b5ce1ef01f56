//! A part of the wire that has not moved for a while becomes fast.

/// Watches a wire while the pointer moves, and says when its first part has cooled.
///
/// # Source
/// Mortensen and Barrett 1995, path cooling. Theirs goes by time and by how often a pixel was on the path; here a look, one
/// for each move of the pointer, is the unit of both: this crate has no clock.
///
/// ```
/// use girtin_watercolorize::scissors::Cooling;
///
/// let mut cooling = Cooling::new(3, 2);
/// let wire = |end: usize| (0..10).map(|x| [x, if x < 6 { 0 } else { end }]).collect::<Vec<_>>();
/// assert_eq!(cooling.look(&wire(1)), None);
/// assert_eq!(cooling.look(&wire(2)), None);
/// assert_eq!(cooling.look(&wire(3)), Some([5, 0]), "the end still moves");
/// ```
#[derive(Clone, Debug)]
pub struct Cooling {
    looks: u32,
    least: usize,
    /// Pixels of the last wire, and at how many looks in a row each was there.
    seen: Vec<([usize; 2], u32)>,
}

impl Cooling {
    /// A part has cooled when it was the same at `looks` looks in a row and is at least `least` pixels long.
    pub fn new(looks: u32, least: usize) -> Self {
        Self { looks: looks.max(1), least, seen: Vec::new() }
    }

    /// Looks at the wire, from its seed on; where its first part has cooled, that part's end is to be the next seed.
    pub fn look(&mut self, wire: &[[usize; 2]]) -> Option<[usize; 2]> {
        let same = wire.iter().zip(&self.seen).take_while(|(point, (known, _))| *point == known).count();
        self.seen.truncate(same);
        self.seen.iter_mut().for_each(|(_, looks)| *looks += 1);
        self.seen.extend(wire[same..].iter().map(|&point| (point, 1)));
        let cooled = self.seen.iter().take_while(|(_, looks)| *looks >= self.looks).count();
        if cooled <= self.least {
            return None;
        }
        let end = self.seen.get(cooled - 1).map(|(point, _)| *point);
        self.seen.clear();
        end
    }
}
