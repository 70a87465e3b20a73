"""Small files of each dialect, one problem with its domain in each; own formulations."""

LOGISTICS = """
; parcels between depots: trucks inside of a town, one plane between towns
(define (domain Parcels)
  (:requirements :strips :typing :equality :conditional-effects :action-costs)
  (:types depot town - object  truck plane - vehicle  parcel vehicle - thing  thing - object)
  (:constants base - depot)
  (:predicates (at ?t - thing ?d - depot) (in ?p - parcel ?v - vehicle) (in-town ?d - depot ?t - town)
               (has-runway ?d - depot) (grounded))
  (:functions (total-cost) - number (km ?a ?b - depot) - number)
  (:action load
    :parameters (?p - parcel ?v - (either truck plane) ?d - depot)
    :precondition (and (at ?p ?d) (at ?v ?d))
    :effect (and (not (at ?p ?d)) (in ?p ?v) (increase (total-cost) 1)))
  (:action unload
    :parameters (?p - parcel ?v - vehicle ?d - depot)
    :precondition (and (in ?p ?v) (at ?v ?d))
    :effect (and (at ?p ?d) (not (in ?p ?v)) (increase (total-cost) 1)))
  (:action drive
    :parameters (?v - truck ?a ?b - depot)
    :precondition (and (at ?v ?a) (not (= ?a ?b)) (exists (?t - town) (and (in-town ?a ?t) (in-town ?b ?t))))
    :effect (and (not (at ?v ?a)) (at ?v ?b) (increase (total-cost) (km ?a ?b))))
  (:action fly
    :parameters (?v - plane ?a ?b - depot)
    :precondition (and (at ?v ?a) (has-runway ?a) (has-runway ?b) (not (grounded)))
    :effect (and (at ?v ?b) (not (at ?v ?a)) (increase (total-cost) (+ 5 (km ?a ?b))))))
(define (problem Two-Towns) (:domain parcels)
  (:objects north south - town  yard dock field - depot  van lorry - truck  jet - plane  box crate - parcel)
  (:init (in-town base north) (in-town yard north) (in-town dock south) (in-town field south)
         (has-runway base) (has-runway field)
         (at van yard) (at lorry dock) (at jet base) (at box yard) (at crate dock)
         (= (total-cost) 0)
         (= (km base yard) 4) (= (km yard base) 4) (= (km dock field) 3) (= (km field dock) 3)
         (= (km base field) 90) (= (km field base) 90))
  (:goal (and (at box dock) (forall (?p - parcel) (or (at ?p dock) (at ?p field)))))
  (:metric minimize (total-cost)))
"""

CLG = """
(define (domain Clinic)
  (:types illness tint)
  (:predicates (ill ?i - illness) (stained ?c - tint) (shows ?i - illness ?c - tint) (mixed) (alive) (cured))
  (:action MIX :precondition (alive)
    :effect (and (mixed) (forall (?i - illness ?c - tint) (when (and (ill ?i) (shows ?i ?c)) (stained ?c)))))
  (:action look :parameters (?c - tint) :precondition (and (mixed) (alive)) :observe (stained ?c))
  (:action treat :parameters (?i - illness) :precondition (and )
    :effect (and (when (ill ?i) (and (not (ill ?i)) (cured))) (when (not (ill ?i)) (not (alive))))))
(define (problem three)
  (:domain clinic)
  (:objects flu cold pox - illness  red blue green - tint)
  (:init (and (alive) (shows flu red) (shows cold blue) (shows pox green)
              (oneof (ill flu) (ill cold) (ill pox))))
  (:goal (and (cured) (alive))))
"""

PKS_UNTYPED = """<?xml version="1.0"?>
<!-- a safe whose combination stands on a note -->
<pks>
  <domain name='vault'>
    <symbols>
      <predicates> open/1, safe/1, note/1, readNote/0, </predicates>
      <functions> combo/1, clicks/0 </functions>
      <constants> s1, n1, c1, c2, c3, </constants>
    </symbols>
    <actions>
      <action name="read">
        <params>?n, ?s</params>
        <preconds>K(note(?n)) ^ K(safe(?s)) & !Kv(combo(?s))</preconds>
        <effects>add(Kv, combo(?s)); add(Kf, readNote)</effects>
      </action>
      <action name="dial">
        <params>?s, ?x</params>
        <preconds>Kv(?x) ^ K(safe(?s)) ^ !K(open(?s)) & clicks < 7</preconds>
        <effects>K(combo(?s) = ?x) => add(Kf, open(?s));
          clicks = clicks + 1</effects>
      </action>
    </actions>
  </domain>
  <problem name="one-safe" domain="vault">
    <init>
      add(Kf, safe(s1)); add(Kf, note(n1)); add(Kf, !open(s1)); add(Kf, clicks = 0);
      add(Kx, combo(s1) = c1 | combo(s1) = c2)
    </init>
    <goal> K(open(s1)) &amp; (existsK(?z) K(safe(?z)) ^ K(readNote)) </goal>
    <updates> K(open(?x)) => add(Kf, safe(?x)) </updates>
  </problem>
</pks>
"""

PKS_TYPED = """<pks><domain name="bar">
 <symbols>
  <predicates>empty(bottle), on(bottle,place), holds(robot, bottle)</predicates>
  <functions>home(bottle):place, weight(bottle):int</functions>
  <constants>b1 : bottle, b2 : bottle, shelf, table : place; r : robot</constants>
 </symbols>
 <action name="grab"><params>?r : robot, ?b : bottle</params>
  <preconds>(existsK(?p : place) K(on(?b, ?p)) & K(?p != shelf)) | K(weight(?b) <= 2)</preconds>
  <effects>add(Kf, holds(?r,?b)) ^ (forallK(?p : place) K(on(?b,?p)) => (del(Kf, on(?b,?p)) ^ add(Kf, !on(?b, ?p))))
   add(Kw, empty(?b))</effects>
 </action>
</domain>
<problem name="p" domain="bar">
 <init>add(Kf, on(b1, shelf)); add(Kf, on(b2, table)); add(Kf, home(b1) = shelf); add(Kf, weight(b1) = 1)</init>
 <goal>(forallK(?b : bottle) K(empty(?b)) => K(holds(r, ?b))) & !K(empty(b2)) xor Kw(empty(b1))</goal>
</problem></pks>
"""
