//! A shuffled deck, dealt to its end before it is shuffled again.

use rand::{Rng, RngExt};

/// Deck that deals its cards in random order, every card equally often.
pub struct CardDeck<T> {
    cards: Vec<T>,
    next: usize,
}

impl<T: Copy> CardDeck<T> {
    /// A deck of `cards`, shuffled at the first deal.
    pub fn new(cards: &[T]) -> Self {
        Self { cards: cards.to_vec(), next: cards.len() }
    }

    /// Deals the next card.
    ///
    /// # Panics
    /// If the deck was made without cards.
    pub fn deal(&mut self, rng: &mut impl Rng) -> T {
        if self.next >= self.cards.len() {
            for i in (1..self.cards.len()).rev() {
                self.cards.swap(i, rng.random_range(0..=i));
            }
            self.next = 0;
        }
        self.next += 1;
        self.cards[self.next - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn every_card_comes_before_one_repeats() {
        let (mut deck, mut rng) = (CardDeck::new(&[1, 2, 3, 4]), Pcg64Mcg::seed_from_u64(3));
        for _ in 0..5 {
            let mut hand: Vec<_> = (0..4).map(|_| deck.deal(&mut rng)).collect();
            hand.sort_unstable();
            assert_eq!(hand, [1, 2, 3, 4]);
        }
    }
}
