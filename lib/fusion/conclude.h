#pragma once

#include <set>
#include <string>

#include "lib/world/mass_function.h"
#include "lib/world/object_belief.h"
#include "lib/world/task.h"

namespace secondlook::fusion {

/// When the evidence of the views settles an object.
struct ConcludeConfig {
  /// A view that could see at least this share of the model, and gives it a lower score than
  /// `strike_score`, strikes the hypothesis …
  double strike_visible_fraction = 0.35;
  double strike_score = 0.1;
  /// … unless of all the pixels that the views saw of it, so many are in views that accept it: one
  /// view may be badly registered or lit.
  double min_held = 0.9;
  /// A hypothesis of whose surface so much lies where the map is likely free is struck (Kriegel
  /// 2013, III-E).
  double max_likely_free = 0.33;
  /// A view that does not accept a hypothesis supports it by no more than this, whatever its score.
  double max_unaccepted = 0.3;
  /// A second pose of the same model keeps the object open unless the best is ahead of it by this
  /// much (see Lead).
  double min_lead = 3.0;
  /// A pose turned by less than `near_deg` is half way to being the same, so it needs to be told
  /// from the best by less.
  double near_deg = 12.0;
  double min_near_lead = 2.0;
  /// In some view the colours must agree this well (where there is colour): stricter than what a
  /// single frame is asked for, as a mission can look again, and another look is cheaper than an
  /// error.
  double min_color_agreement = 0.78;
  /// Of all the pixels that the views saw of it, so many are in views that accept it.
  double min_accepting = 0.8;
  /// A view that saw fewer pixels of it may accept it, but its objection does not count.
  int min_objecting_px = 250;
  /// Each view's masses are discounted by this (Shafer): views share errors.
  double view_reliability = 0.97;
  /// An object is unknown when at least this many views saw it clearly …
  int unknown_views = 2;
  /// … and m(Omega) / (1 - m(empty)) is still at least this: nothing in the database fits. It is
  /// unknown as well when one more did, and none of them accepts a hypothesis.
  double unknown_ignorance = 0.6;

  template <class A>
  void Serialize(A* a) {
    a->Visit("strike_visible_fraction", &strike_visible_fraction);
    a->Visit("strike_score", &strike_score);
    a->Visit("min_held", &min_held);
    a->Visit("max_likely_free", &max_likely_free);
    a->Visit("max_unaccepted", &max_unaccepted);
    a->Visit("min_lead", &min_lead);
    a->Visit("near_deg", &near_deg);
    a->Visit("min_near_lead", &min_near_lead);
    a->Visit("min_color_agreement", &min_color_agreement);
    a->Visit("min_accepting", &min_accepting);
    a->Visit("min_objecting_px", &min_objecting_px);
    a->Visit("view_reliability", &view_reliability);
    a->Visit("unknown_views", &unknown_views);
    a->Visit("unknown_ignorance", &unknown_ignorance);
  }
  /// @throws ConfigError naming the value.
  void Validate() const;
};

/// By how much the views prefer `a` to `b`: the difference of the log-odds of their scores, summed
/// over the views that were asked about both. Positive: `a` is the better one. Where a view saw
/// fewer than `min_objecting_px` of one, whether it accepts it or not counts for nothing.
double Lead(const ConcludeConfig& config, const world::PoseHypothesis& a,
            const world::PoseHypothesis& b);

/// The lead that `best` needs over `other`, another pose of the same model.
double NeededLead(const ConcludeConfig& config, const world::PoseHypothesis& best,
                  const world::PoseHypothesis& other);

/// What the pictures of an object say of its class, whatever its shape.
struct Appearance {
  world::MassFunction masses;           ///< Of all its views together; vacuous: nothing.
  std::set<std::string> without_model;  ///< Those of its classes that shape cannot tell of.
};

/// Draws the conclusion from the evidence in `object->hypotheses`: sets
/// every hypothesis's support, struck and reason, their order, the object's
/// masses, state and reason. `clear_views` is the number of views in which it was seen well
/// enough to be recognised. A pure function of the evidence; the order of the views does not
/// matter.
///
/// - A hypothesis's support is the mean of its scores' log-odds, weighted by the pixels each view
///   saw of it, as a probability: a pose that fits one view and not the other falls behind the one
///   that fits both.
/// - A class counts in every view with what that view says of the class's best surviving
///   hypothesis; the masses of the views are combined by the transferable belief model.
/// - Verified: the class has the confidence that the task asks for, the hypothesis was accepted in
///   some view with colours that agree well and by most of what was seen of it, and no other pose
///   of the class comes near. Unknown: see ConcludeConfig. Otherwise the object stays a candidate,
///   and the reason says what is open.
/// - `appearance` joins the masses by the same rule, so that a print can settle what fits several
///   models alike. It makes no model fit: whether one does is for shape to say, and after enough
///   clear views in which none does, what the pictures say of classes that have one is conflict: a
///   new object. Nor is it asked where a hypothesis stands for a class that it does not tell of.
/// - Classified: no model is known of the class that leads, and it has the confidence that the task
///   asks for, after as many clear views as "unknown" takes. With less it stays a candidate, unless
///   so little speaks for it that the object is unknown.
void Conclude(const world::Task& task, const ConcludeConfig& config, int clear_views,
              const Appearance& appearance, world::ObjectBelief* object);

/// The same by shape alone.
void Conclude(const world::Task& task, const ConcludeConfig& config, int clear_views,
              world::ObjectBelief* object);

}  // namespace secondlook::fusion
