#pragma once

#include <map>
#include <string>

#include "lib/world/mass_function.h"

namespace secondlook::fusion {

/// The masses of one view, from the support in [0, 1] that it gives to each class by itself: every
/// class c is a simple support function {m({c}) = s, m(Omega) = 1 - s}, combined by Dempster's rule
/// with normalisation, since the hypotheses of one view compete for the same pixels and their
/// conflict says nothing. Two look-alikes of support 0.9 each get 0.47 each; nothing supported
/// gives m(Omega) = 1.
/// @throws InvalidArgument for a support outside [0, 1] or NaN, naming the class.
world::MassFunction FromSupports(const std::map<std::string, double>& supports);

/// The transferable belief model's conjunctive, un-normalised combination of two views (Hoseini
/// 2018, Eq. 2). Commutative and associative; conflict between the views stays as m(empty set).
world::MassFunction Combine(const world::MassFunction& a, const world::MassFunction& b);

/// `m` when its view is right only with the probability `reliability`: the rest of every mass is
/// moved to Omega (Shafer's discounting). @pre `reliability` in [0, 1].
world::MassFunction Discounted(world::MassFunction m, double reliability);

/// How far two views disagree in what they commit themselves to: m(empty) of their combination over
/// the most that it could be, the product of what each gives to classes rather than to Omega. In
/// [0, 1]; 0 where either commits itself to nothing. Unlike m(empty) it is that of the views as
/// they were, however they are discounted. @pre Neither has a conflict of its own.
double CommittedConflict(const world::MassFunction& a, const world::MassFunction& b);

/// The pignistic probabilities (Hoseini 2018, Eq. 3) over `class_count` >= 1 classes, normalised to
/// sum to 1 over all of them; only classes that have a mass of their own are listed, each of the
/// others has the share of Omega, m(Omega) / class_count / (1 - m(empty)).
/// @pre a.conflict < 1.
std::map<std::string, double> Pignistic(const world::MassFunction& m, int class_count);

/// The share of what is not conflict that stands for `c` alone: m({c}) / (1 - m(empty)), the
/// normalised belief. Unlike the pignistic probability it never turns ignorance into confidence, so
/// it is what an object is verified by. 0 in total conflict.
double NormalisedBelief(const world::MassFunction& m, const std::string& c);

/// m(Omega) / (1 - m(empty)): how much is still open, or the object unlike all that is known. 1 in
/// total conflict.
double NormalisedIgnorance(const world::MassFunction& m);

}  // namespace secondlook::fusion
