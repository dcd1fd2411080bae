"""Vision App: finds stalls, cars and lot in one frame."""
