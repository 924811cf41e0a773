// How the films of a job's iterations become one image.
#pragma once

#include <span>
#include <vector>

#include "core/film/film.h"
#include "core/learning/method.h"

namespace lodestar {

struct CombinedFilms {
  std::vector<double> weights;  // in the films' order; they add up to 1 (all 0 while nothing is rendered)
  Image image;                  // the weighted mean of the films' images; those of films are independent
  uint64_t passes = 0;          // of the films with a weight
};

// `films` is not empty.
// - discard, automatic: the film with the most passes alone, the later of equals: the last iteration's, but for the
// first rounds of a longer one.
// - inverse variance: of all films, 1 / mean pixel variance (Mueller 2019, section 10.2), relative to what the pixels
//   should have, as errors are reported: by the absolute variance a film that is noisy in the dark would count by its
//   bright parts. Two things are known of a variance beside its samples. Guides get better: a film is at least as noisy
//   a pass as later ones of its candidate. And a film without any noise has met nothing that varies, no light perhaps:
//   it counts as the noisiest. A film of one pass is measured against the others. The weights come from the samples
//   they weigh: with a whole image's mean variance behind each, the bias is of the order of the relative error of that
//   mean, over the number of pixels; tests of means use discard.
CombinedFilms Combine(std::span<const IterationFilm> films, Method::Combination combination);

// Makes room for another film after an iteration; `weights` are Combine's.
// - discard, automatic: the last one stays.
// - inverse variance: none is lost. Of the candidate that rendered the last one, the last two stay apart, since a race
//   compares them; those before become one film, their mean by their weights. So there are at most three of each
//   candidate, however many iterations it has.
void MakeRoom(std::vector<IterationFilm>* films, Method::Combination combination, std::span<const double> weights);

// The most films that iterations of one candidate have at a time: those that MakeRoom leaves, and the one that is being
// rendered.
size_t MostFilms(Method::Combination combination);

}  // namespace lodestar
